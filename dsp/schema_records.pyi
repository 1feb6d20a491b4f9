"""Records of the numbers that the schema declares, as the engine holds them; `make documents` writes this."""

import numpy as np

from .native.typed import Record

class Steered(Record):
    """A value for each steerable parameter."""

    position: float
    gain: float  # as amplitude
    x: float  # m
    y: float  # m
    z: float  # m
    gravity: float  # m/s^2
    irregularity: float
    speed: float  # m/s
    mass: float  # kg
    stiffness: float  # N/m^a
    dissipation: float  # s/m
    exponent: float
    radius: float  # m
    roughness: float  # times
    asymmetry: float
    friction: float
    force: float  # N
    flat: float
    sweep: float  # m/s
    patch: float  # m
    static: float
    dynamic: float
    stribeck: float  # m/s
    tangential: float  # N/m
    along: float
    load: float
    by_x: float  # m
    by_y: float  # m
    by_z: float  # m
    by_position: float
    rate: float  # 1/s
    size: float  # m
    evenness: float
    excitation: float
    memory: float  # s
    variety: float
    density: float  # 1/m
    energy: float  # J
    steepness: float
    decades: float
    height: float  # m
    crackles: float  # 1/N

class Values(Record):
    """The values of a gesture: the parameters of all gestures, 0 for those that it has not."""

    velocity: float  # m/s
    mass: float  # kg
    stiffness: float  # N/m^a
    dissipation: float  # s/m
    exponent: float
    restitution: float
    position: float
    gain: float  # as amplitude
    x: float  # m
    y: float  # m
    z: float  # m
    by_position: float
    by_x: float  # m
    by_y: float  # m
    by_z: float  # m
    direction_x: float
    direction_y: float
    direction_z: float
    by_direction_x: float
    by_direction_y: float
    by_direction_z: float
    on_surface: float
    by_on_surface: float
    sound: float
    sound_serial: float
    press: float
    delay: float  # s
    pulses: float
    whole: float  # kg
    friction: float
    own_stiffness: float  # N/m^a
    own_dissipation: float  # s/m
    own_level: float
    level: float
    stage: float
    impulse: float  # N s
    gravity: float  # m/s^2
    irregularity: float
    seed: float
    weight: float
    radius: float  # m
    roughness: float  # times
    asymmetry: float
    corners: float
    travel: float  # m
    speed: float  # m/s
    force: float  # N
    angle: float  # degrees
    quickening: float
    flat: float
    duration: float  # s
    sweep: float  # m/s
    patch: float  # m
    static: float
    dynamic: float
    stribeck: float  # m/s
    tangential: float  # N/m
    along: float
    load: float
    size: float  # m
    reach: float
    spread: float
    rate: float  # 1/s
    evenness: float
    excitation: float
    memory: float  # s
    variety: float
    density: float  # 1/m
    energy: float  # J
    steepness: float
    decades: float
    height: float  # m
    crackles: float  # 1/N
    pieces: float
    wall_mass: float  # kg
    thick_mass: float  # kg
    thick_ratio: float  # times
    thick_parts: float

class Settings(Record):
    """The settings of an object."""

    gain: float  # as amplitude
    pan: float
    distance: float  # m
    tune: float  # as ratio
    decay: float  # times
    damp: float
    hardness: float
    force: float  # N
    place: float
    roughness: float  # times
    size: float  # m
    material: float
    brightness: float
    damping: float
    morph: float

class RampValues(Record):
    """The time that a change takes, and how."""

    over: float  # s
    curve: float
    after: float  # s

class Traits(Record):
    """The traits of a gesture: see `Gesture`."""

    single: int
    repeats: int
    falls: int
    held: int
    rolls: int
    slips: int
    rests: int
    along: int
    lasts: int
    meets: float
    swarms: int
    treads: int
    breaks: int

class Counters(Record):
    """The counters as the engine holds them: see `Stats`."""

    impacts: int
    contacts_dropped: int
    coupled: int
    recontacts: int
    held: int
    over_budget: int
    late: int
    faults: int
    limited: int  # frames
    strikers_cut: int
    ramps_dropped: int
    nonlinear_dropped: int
    tap_lost: int  # frames
    notes_lost: int
    trace_lost: int  # samples
    underflows: int
    holes: int
    hole_at: int  # frames
    overruns: int
    callbacks: int
    synced: int
    contacts_active: int
    rolls_active: int
    coupled_modes: int
    nonlinear_active: int
    live_modes: int
    sounding: int
    sounded: int  # samples
    limit_lowest: float
    headroom: float
    load: float
    load_now: float
    load_peak: float
    loudest_dropped: float
    late_last: float  # s
    hole_last: float  # s
    late_worst: float  # s
    latency_measured: float  # s

STATS: np.dtype[np.void]
STEERED: np.dtype[np.void]
VALUES: np.dtype[np.void]
