#!/bin/sh
# Makes a glass plate and strikes it four times, with oscsend (of liblo-tools). Usage: strike.sh [PORT]
set -eu
port=${1:-57140}

carom() { oscsend localhost "$port" "$@"; }

carom /object/new ss plate glass-plate
sleep 0.5
for velocity in 0.2 0.5 1 2; do
    carom /object/plate/impact ffss "$velocity" 0.3 striker steel
    sleep 0.5
done
carom /object/plate/free
