"""Slip, sweep and normal force of a contact from step to step, smoothed."""

import math

from ....dsp.native.jit import kernel
from .points import into, slip_at
from .state import Glide, Pair, State

_SMOOTH = 0.005  # s: time constant of slip and sweep
_SMOOTH_FORCE = 0.1  # s: of the force
_SMOOTH_PLACE = 0.05  # s: of the place
_REMEMBERED = 0.2  # s: time constant with which a fast slip is forgotten
_ALIKE = 1e-3  # share by which two steps may differ and count as equally long
_STEADY = 0.1  # s without a hop, after which a contact's force is taken step by step again
_STAYS_AT = 0.1  # share of its sweep over one body, at which a contact that is slower over the other stays there


@kernel
def find_glide(glide: Glide, span: float) -> None:
    """Find how far a contact's motion, its place and its force glide in a time (s), unless it is the same as before."""
    if glide.span == span:
        return
    glide.span = span
    glide.share, glide.near = -math.expm1(-span / _SMOOTH), -math.expm1(-span / _SMOOTH_PLACE)
    glide.remembered = math.exp(-span / _REMEMBERED)
    glide.harder = -math.expm1(-span / _SMOOTH_FORCE)


@kernel
def follow(state: State, pair: Pair, span: float) -> None:
    """Find how a contact slips and sweeps, and how hard it is pressed, smoothed."""
    passed = state.time - pair.last if pair.settled > 0 else span
    pair.last = state.time
    glide, landed = state.glide, passed != span
    if landed:
        glide = state.hop
        find_glide(glide, passed)
    share, near = glide.share, glide.near
    for side in range(2):
        for k in range(3):
            at = into(state, pair.a if side == 0 else pair.b, pair.point, k)
            pair.local[side, k] += (near if pair.settled > 0 else 1.0) * (at - pair.local[side, k])
        if pair.followed > 0:
            swept = pair.swept[side] / pair.followed
            pair.sweep[side] += (share if pair.settled > 1 else 1.0) * (swept - pair.sweep[side])
    slip = pair.slip / pair.weight
    if pair.settled == 0:
        pair.now[0] = slip
    pair.fastest = max(slip, pair.fastest * glide.remembered)
    pair.hops = max(pair.hopping, pair.hops * glide.remembered)
    pair.now[0] += share * (slip - pair.now[0])
    if pair.settled < 2:
        pair.settled = 2 if pair.followed > 0 else 1
        if pair.followed == 0:  # it is likely to go over the larger body
            pair.sweep[0 if state.reach[pair.a] >= state.reach[pair.b] else 1] = pair.now[0]
    pair.now[1] = max(pair.sweep[0], pair.sweep[1])
    _press(state, pair, span, landed)


@kernel
def _press(state: State, pair: Pair, span: float, landed: bool) -> None:
    """Smooth a contact's force: of one that hops, its mean between landings; its weight where none is reported."""
    weight = weight_of(state, pair)
    if pair.now[2] == 0.0:
        pair.now[2] = weight if weight > 0.0 else pair.force
    if pair.force == 0.0 and pair.pushed == 0.0:
        pair.now[2] += state.glide.harder * (weight - pair.now[2])
        return
    if pair.over > 0.0 and (landed or state.time - pair.hopped_at > _STEADY):
        alone = abs(pair.over - span) < _ALIKE * span
        share = state.glide.harder if alone else -math.expm1(-pair.over / _SMOOTH_FORCE)
        pair.now[2] += share * (pair.pushed / pair.over - pair.now[2])
        pair.pushed = pair.over = 0.0
    pair.pushed += pair.force * span
    pair.over += span


@kernel
def hop(state: State, pair: Pair, span: float) -> None:
    """Find how a contact that hops slips on: as its bodies move where it was last, or as it was reported.

    One that stays at its place on one body sweeps over the other as fast as it slips.
    """
    pair.hopped_at = state.time
    if pair.pushed > 0.0:
        pair.over += span
    if pair.told == 1:
        return
    share = state.glide.share
    slip = slip_at(state, pair)
    pair.now[0] += share * (slip - pair.now[0])
    for side in range(2):
        if pair.sweep[1 - side] < _STAYS_AT * pair.sweep[side]:
            pair.sweep[side] += share * (slip - pair.sweep[side])
    pair.now[1] = max(pair.sweep[0], pair.sweep[1])


@kernel
def weight_of(state: State, pair: Pair) -> float:
    """Return the weight (N) of the lighter body of a pair."""
    lightness = max(state.lightness[pair.a], state.lightness[pair.b])
    return state.gravity / lightness if lightness > 0.0 else 0.0
