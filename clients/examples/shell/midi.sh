#!/bin/sh
# Starts a server that a MIDI keyboard plays: a marimba below middle C, a bell from there on. The first knob that is
# turned sets for how long both ring. Usage: midi.sh [INPUT [PORT [OPTION of carom serve ...]]], until Ctrl-C.
# INPUT: as `carom devices` lists it; without one, an input of Carom's own, for a DAW to connect to.
set -eu
input=${1:-virtual}
port=${2:-57140}
shift $(($# < 2 ? $# : 2))

send() { carom send --port "$port" "$@"; }

carom serve --midi "$input" --port "$port" "$@" &
server=$!
trap 'kill $server 2>/dev/null || true' EXIT
trap 'exit 130' INT TERM
until send /sync 1 >/dev/null 2>&1; do
    kill -0 $server 2>/dev/null || exit 1 # it has said why
    sleep 0.2
done
send /object/new marimba marimba-bar
send /object/new bell church-bell
send /midi/notes marimba high B3
send /midi/notes bell low C4
send /midi/learn '/object/*/decay' low 0.1 high 2
wait $server
