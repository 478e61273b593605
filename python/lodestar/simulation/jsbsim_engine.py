# SPDX-License-Identifier: Apache-2.0
"""The second engine: the F-16 of JSBSim flown along a path by the autopilot.

Its truth is not ours: aerodynamics, engine, fly-by-wire, rotating Earth and integration are
JSBSim's. The aircraft follows direction and height of the path at the path's own time, as well as
it can; wind, gusts and what it cannot do show in the flight, not only in the sensors.

JSBSim and its aircraft files come with the Python package ``jsbsim`` and are used as they are.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodestar.errors import InputError
from lodestar.rotation import C_NB_from_euler
from lodestar.simulation.autopilot import Autopilot, Controls, Motion, Vector, aims
from lodestar.simulation.earth import STANDARD_GRAVITY, meridian_radius, transverse_radius
from lodestar.simulation.flight_path import FlightError, FlightPath, Start
from lodestar.simulation.sensor_errors import random_stream
from lodestar.simulation.trajectory import Trajectory, assemble, continuous_q_NB
from lodestar.simulation.wind import Turbulence, Wind

Array = NDArray[np.float64]

RUN_IN = 15.0  # s of flight before the first sample, in which everything settles
SLOWEST, FASTEST = 110.0, 320.0  # m/s, of paths it can fly
SLOWEST_RATE_HZ = 60
LEAST_FORWARD_SPEED = 40.0  # m/s, of an aircraft that is flying
FOOT = 0.3048  # m

# With those that JSBSim has by default its attitude is, after a few fast rolls, 0.6 degrees from
# the integral of its own rates. Adams-Bashforth of order 2 and 3 for the rates, Buss's
# second for the attitude, Adams-Bashforth of order 3 for the position.
_INTEGRATORS = {
    "rate/rotational": 3,
    "rate/translational": 4,
    "position/rotational": 7,
    "position/translational": 4,
}
_MEASURED = (
    "position/lat-geod-rad",
    "position/long-gc-rad",
    "position/geod-alt-ft",
    "velocities/v-north-fps",
    "velocities/v-east-fps",
    "velocities/v-down-fps",
    "attitude/phi-rad",
    "attitude/theta-rad",
    "attitude/psi-rad",
    # Relative to the inertial frame; p-rad_sec is relative to the Earth.
    "velocities/pi-rad_sec",
    "velocities/qi-rad_sec",
    "velocities/ri-rad_sec",
    # Of this frame; accelerations/Nz is one frame late.
    "forces/fbx-total-lbs",
    "forces/fby-total-lbs",
    "forces/fbz-total-lbs",
)
_CONTROLS = (
    "fcs/aileron-cmd-norm",
    "fcs/elevator-cmd-norm",
    "fcs/rudder-cmd-norm",
    "fcs/yaw-trim-cmd-norm",
    "fcs/throttle-cmd-norm",
    "fcs/speedbrake-cmd-norm",
)
_WIND = ("atmosphere/wind-north-fps", "atmosphere/wind-east-fps", "atmosphere/wind-down-fps")
# The model's own yaw loop: rudder = 0.1055 (pedals + 100 r + 0.25 n_y).
_YAW_LOOP, _YAW_RATE, _YAW_LOAD = 0.1055, 100.0, 0.25
_STICK_PER_ROLL_RATE = 0.31821  # s


class _F16:
    """The aircraft in JSBSim, in SI."""

    def __init__(self, start: Start, wind_N: Vector, rate_hz: int) -> None:
        """In flight, ``RUN_IN`` seconds before the start, along its heading."""
        jsbsim = _package()
        jsbsim.FGJSBBase().debug_lvl = 0
        fdm: Any = jsbsim.FGFDMExec(None)
        fdm.set_debug_level(0)
        fdm.load_model("f16")
        fdm.set_dt(1 / rate_hz)
        for name, method in _INTEGRATORS.items():
            fdm[f"simulation/integrator/{name}"] = method
        north = start.airspeed * math.cos(start.heading) + wind_N[0]
        east = start.airspeed * math.sin(start.heading) + wind_N[1]
        circle = (float(transverse_radius(start.lat)) + start.altitude) * math.cos(start.lat)
        radius = float(meridian_radius(start.lat)) + start.altitude
        fdm["ic/lat-geod-rad"] = start.lat - RUN_IN * north / radius
        fdm["ic/long-gc-rad"] = start.lon - RUN_IN * east / circle
        fdm["ic/h-sl-ft"] = start.altitude / FOOT
        fdm["ic/psi-true-rad"] = start.heading
        fdm["ic/theta-deg"] = 2.0
        fdm["ic/vn-fps"] = north / FOOT
        fdm["ic/ve-fps"] = east / FOOT
        fdm.run_ic()
        fdm["propulsion/set-running"] = -1
        fdm["propulsion/fuel_freeze"] = 1
        fdm["gear/gear-cmd-norm"] = 0
        fdm["gear/gear-pos-norm"] = 0
        nodes = fdm.get_property_manager()
        self._run: Callable[[], bool] = fdm.run
        self._get = [nodes.get_node(name).get_double_value for name in _MEASURED]
        self._control = [nodes.get_node(name).set_double_value for name in _CONTROLS]
        self._set_wind = [nodes.get_node(name).set_double_value for name in _WIND]
        force = FOOT / fdm["inertia/mass-slugs"]
        self._scale = [1.0] * 2 + [FOOT] * 4 + [1.0] * 6 + [force] * 3

    def state(self) -> list[float]:
        """lat, lon, h, v_N, roll, pitch, heading, omega_B, f_B."""
        return [get() * scale for get, scale in zip(self._get, self._scale, strict=True)]

    def step(self, controls: Controls, motion: Motion, wind: Vector) -> None:
        """Fly one sample further, to where the whole wind is ``wind``."""
        # The trim takes back what the pedals do besides the yaw loop.
        pedals = controls.rudder / _YAW_LOOP
        pedals -= _YAW_RATE * motion.omega_B[2] + _YAW_LOAD * motion.n_B[1]
        values = (
            controls.roll_rate * _STICK_PER_ROLL_RATE,
            -controls.pull,
            pedals,
            -pedals,
            controls.throttle,
            float(controls.brake),
        )
        for move, value in zip(self._control, values, strict=True):
            move(value)
        for blow, value in zip(self._set_wind, wind, strict=True):
            blow(value / FOOT)
        self._run()


def fly_jsbsim(
    path: FlightPath, wind: Wind, turbulence: Turbulence, decimal_year: float, seed: int
) -> Trajectory:
    """Fly a path with JSBSim's F-16, in wind and turbulence drawn from ``seed``.

    Raises InputError where the package jsbsim is missing, and FlightError for a path that the
    aircraft cannot fly.
    """
    _check(path)
    interval = 1 / path.rate_hz
    before = round(RUN_IN * path.rate_hz)
    count = len(path.airspeed)
    t = interval * np.arange(count, dtype=np.float64)
    wind_N = wind.velocity_N(t, random_stream(seed, "wind"))
    wind_N = np.concatenate([np.repeat(wind_N[:1], before, axis=0), wind_N])
    gust_B = turbulence.gust_B(
        before + count, interval, float(np.mean(path.airspeed)), random_stream(seed, "turbulence")
    )
    states, total_wind_N = _fly(path, wind_N, gust_B, before)
    lat, lon, h = states[:, :3].T.copy()
    C_NB = C_NB_from_euler(*states[:, 6:9].T)
    return assemble(
        path.rate_hz,
        lat=lat,
        lon=lon,
        h=h,
        v_N=states[:, 3:6],
        C_NB=C_NB,
        q_NB=continuous_q_NB(C_NB),
        omega_B=states[:, 9:12],
        f_B=states[:, 12:15],
        wind_N=total_wind_N,
        decimal_year=decimal_year,
    )


def version() -> str:
    """Of JSBSim. Raises InputError where the package jsbsim is missing."""
    return str(_package().__version__)


def _check(path: FlightPath) -> None:
    # One step per sample: what happened between samples could not be found from them.
    if path.rate_hz < SLOWEST_RATE_HZ:
        raise FlightError(f"rate {path.rate_hz} Hz: JSBSim needs {SLOWEST_RATE_HZ} Hz at least")
    slowest, fastest = float(np.min(path.airspeed)), float(np.max(path.airspeed))
    if slowest < SLOWEST or fastest > FASTEST:
        raise FlightError(
            f"airspeed {slowest:.0f} to {fastest:.0f} m/s: the F-16 flies {SLOWEST:g} to "
            f"{FASTEST:g} m/s"
        )


def _fly(path: FlightPath, wind_N: Array, gust_B: Array, before: int) -> tuple[Array, Array]:
    """States (n, 15) and whole wind (n, 3), both without the ``before`` samples of run-in."""
    goals = aims(path)
    winds: list[Vector] = wind_N.tolist()
    gusts: list[Vector] = gust_B.tolist()
    aircraft = _F16(path.start, winds[0], path.rate_hz)
    autopilot = Autopilot(1 / path.rate_hz)
    states, blown = [], []
    blowing = winds[0]
    for k, wind in enumerate(winds):
        state = aircraft.state()
        states.append(state)
        blown.append(blowing)
        motion = _motion(state, wind)
        _check_flying(motion, (k - before) / path.rate_hz)
        if k + 1 == len(winds):
            break
        controls = autopilot.steer(goals[max(k - before, 0)], motion)
        blowing = _blow(winds[k + 1], gusts[k + 1], motion)
        aircraft.step(controls, motion, blowing)
    return np.array(states[before:]), np.array(blown[before:])


def _motion(state: list[float], wind: Vector) -> Motion:
    _, _, h, north, east, down, roll, pitch, heading, p, q, r, *f_B = state
    sr, cr = math.sin(roll), math.cos(roll)
    sp, cp = math.sin(pitch), math.cos(pitch)
    sh, ch = math.sin(heading), math.cos(heading)
    return Motion(
        h=h,
        v_air_N=(north - wind[0], east - wind[1], down - wind[2]),
        x_B=(cp * ch, cp * sh, -sp),
        y_B=(ch * sp * sr - sh * cr, sh * sp * sr + ch * cr, cp * sr),
        z_B=(ch * sp * cr + sh * sr, sh * sp * cr - ch * sr, cp * cr),
        omega_B=(p, q, r),
        n_B=(-f_B[0] / STANDARD_GRAVITY, -f_B[1] / STANDARD_GRAVITY, -f_B[2] / STANDARD_GRAVITY),
    )


def _blow(wind: Vector, gust_B: Vector, motion: Motion) -> Vector:
    """Wind and gust together, in N."""
    a, b, c = gust_B
    rows = zip(wind, motion.x_B, motion.y_B, motion.z_B, strict=True)
    north, east, down = (w + a * x + b * y + c * z for w, x, y, z in rows)
    return north, east, down


def _check_flying(motion: Motion, time: float) -> None:
    along = sum(v * x for v, x in zip(motion.v_air_N, motion.x_B, strict=True))
    if motion.h < 0.0 or along < LEAST_FORWARD_SPEED:
        raise FlightError(
            f"the F-16 is lost {max(time, 0.0):.0f} s into the flight, at {motion.h:.0f} m and "
            f"{along:.0f} m/s forward; ask for less load or more height"
        )


def _package() -> ModuleType:
    try:
        import jsbsim
    except ImportError:
        raise InputError(
            "engine jsbsim: the Python package jsbsim is missing; pip install 'lodestar[jsbsim]'"
        ) from None
    package: ModuleType = jsbsim
    return package
