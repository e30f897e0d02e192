"""Runs of a load set down, dropped, dragged and picked up, against closed forms and invariants."""

from dataclasses import replace
from math import asinh, atan, cos, log1p, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import crane_sim
from crane_sim import Rollout

G, MASS, FLOOR = 9.81, 1000.0, -20.0
CORNERS = [[1.0, 2.0, -2.0], [1.0, -2.0, -2.0], [-1.0, 2.0, -2.0], [-1.0, -2.0, -2.0]]
DECK = {"heave": {"amplitude": 0.0, "frequency": 1.0}}
SQUARE = [[1, 1, 0], [1, -1, 0], [-1, 1, 0], [-1, -1, 0]]


def hoisting(first: float, second: float) -> dict[str, Any]:
    """Return inputs that drive the hoist at one rate [m/s], then at another one."""
    return {
        "hoist": {
            "kind": "table",
            "times": [0, 1, 4, 5, 10],
            "values": [first, first, first, second, second],
        }
    }


def scene(
    contact: dict[str, Any], start: dict[str, Any], duration: float, **changes: Any
) -> dict[str, Any]:
    """Return a scene with slack falls unless `changes` shorten them.

    All have models of the same types.
    """
    return {
        "crane": "gantry",
        "duration": duration,
        "trolley": {"mass": 2e4},
        "bridge": {"mass": 1e5},
        "hoist": {"drive": "rate", "time_constant": 0.3},
        "falls": {"top": SQUARE, "bottom": SQUARE, "axial_stiffness": 2e6, "relaxation": 0.02},
        "payload": {"mass": MASS, "inertia": [1500, 900, 2000], "attachment": [0, 0, 1.0]},
        "contact": {"points": CORNERS, "height": FLOOR, "motion": DECK} | contact,
        "initial": {"length": 60.0} | start,
        "inputs": hoisting(0.0, 0.0),
        "integrator": {"method": "dop853", "rtol": 1e-10, "atol": 1e-12},
    } | changes


def times_of(run: Rollout, text: str) -> list[float]:
    """Return the times [s] of the events that contain a text."""
    return [t for t, what in run.events if text in what]


def heights(run: Rollout) -> Any:
    """Return the heights (K, n) [m] of the corners above the surface at all instants."""
    contact, (w, a, b, c) = run.scene.model.contact, run.q[:, 6:10].T
    row = np.stack(
        [2.0 * (a * c - w * b), 2.0 * (b * c + w * a), 1.0 - 2.0 * (a * a + b * b)], axis=1
    )
    size, rate, phase = (part[2, 0] for part in contact.surface.motion[1:])
    deck = contact.surface.height + size * np.sin(rate * run.t + phase)
    return run.q[:, 5:6] + row @ contact.points.T - deck[:, None]


def test_bounces_of_a_dropped_load() -> None:
    """A load dropped flat flies 2 e v / g between impacts, each e times the one before.

    Bounces end where it is too slow.
    """
    drop, e = 0.5, 0.5
    start = {"position": [0.0, 0.0, FLOOR + 1.0 + drop]}
    run = crane_sim.simulate(scene({"restitution": e, "rest_velocity": 0.01}, start, 1.2))
    speed = sqrt(2.0 * G * drop)
    flights = [speed / G, *(2.0 * speed * e**k / G for k in range(1, 9))]
    expected = np.cumsum(flights)
    # the depth at which a corner touches shifts the impacts
    np.testing.assert_allclose(times_of(run, "bounces off"), expected, rtol=1e-9)
    (end,) = times_of(run, "point 1 touches")
    assert end == pytest.approx(expected[-1] + 2.0 * speed * e**9 / G, rel=1e-9)
    for k, t in enumerate(expected[:4]):  # these flights are longer than a period
        after = np.searchsorted(run.t, t)
        energy = 0.5 * MASS * (e ** (k + 1) * speed) ** 2
        height = run.q[after, 5] - FLOOR - 1.0
        assert run.derived.kinetic[after] + MASS * G * height == pytest.approx(
            energy, abs=2e-10 * MASS * G
        )  # m, of depth
    assert run.summary["energy_audit_max"] < 1e-9


@pytest.mark.long
def test_sliding_distance() -> None:
    """A load that slides flat at v stops near Coulomb's v² / (2 μ g).

    The distance is ∫ √(v² + v_s²) dv / (μ g) from v_s to v.
    """
    friction, v, slip = 0.3, 1.0, 1e-3
    start = {"position": [0.0, 0.0, FLOOR + 1.0], "velocity": [v, 0.0, 0.0]}
    run = crane_sim.simulate(scene({"friction": friction, "slip_velocity": slip}, start, 0.6))

    def way(speed: float) -> float:
        """Return ∫ √(v² + v_s²) dv / (μ g) up to a speed."""
        root = sqrt(speed**2 + slip**2)
        return 0.5 * (speed * root + slip**2 * asinh(speed / slip)) / (friction * G)

    assert run.q[-1, 3] == pytest.approx(way(v) - way(slip), rel=1e-8)  # the method's error
    # friction that is smoothed below v_s is weaker than Coulomb's: the way is longer by 5.8e-6 of
    # it
    assert run.q[-1, 3] == pytest.approx(v**2 / (2.0 * friction * G), rel=1e-5)
    assert len(times_of(run, "the load sticks to")) == 1 and not run.v[-1, 3:].any()
    assert run.summary["energy_audit_max"] < 1e-9


def test_peak_of_a_load_that_is_picked_up_at_a_speed() -> None:
    """A load lifted off a surface that leaves it at v_r pulls up to W (1 + v_r / g √(k / m)).

    The rope is undamped.

    The deck sinks through its middle, where its speed is stationary, as the falls carry the whole
    weight. From there the load oscillates about its equilibrium, with the deck's speed, away from
    the deck.
    """
    # m, N/m, m, rad/s, s from start to lift-off
    length, k, size, rate, start = 15.0, 4e5, 0.1, 2.0, 0.15
    speed, omega = size * rate, sqrt(k / MASS)
    phase = pi - rate * start
    deck = {"heave": {"amplitude": size, "frequency": rate, "phase": phase}}
    rest = -length - MASS * G / k  # m, of the attachment with the deck in its middle
    falls = {
        "top": SQUARE,
        "bottom": SQUARE,
        "axial_stiffness": 0.25 * k * length,
        "relaxation": 0.0,
    }
    contact = {"height": rest - 2.0, "motion": deck}  # the corners are 2 m below the attachment
    position = [0.0, 0.0, rest - 1.0 + size * sin(phase)]
    initial = {"length": length, "position": position, "velocity": [0, 0, size * rate * cos(phase)]}
    exact = {"method": "dop853", "rtol": 1e-12, "atol": 1e-14}
    duration = start + 0.5 * pi / omega
    loaded = crane_sim.load_scene(scene(contact, initial, 1.0, falls=falls, integrator=exact))
    run = crane_sim.simulate(replace(loaded, period=duration / 20, duration=duration))
    # s, depth of touching corners over v_r
    assert times_of(run, "leaves") == pytest.approx([start] * 4, abs=1e-8)
    assert run.tensions[-1].sum() == pytest.approx(MASS * G * (1.0 + speed / G * omega), rel=1e-9)
    assert run.summary["energy_audit_max"] < 1e-9


def test_a_load_on_a_ship_moves_with_it() -> None:
    """On a base that heaves and rolls a load set down on it stays, and the energies balance."""
    ship = {
        "heave": {"amplitude": 0.5, "frequency": 0.8},
        "roll": {"amplitude": 0.05, "frequency": 0.9},
    }
    start = {"position": [0, 0, FLOOR + 1.001]}
    run = crane_sim.simulate(scene({"friction": 0.3, "motion": None}, start, 0.6, base_motion=ship))
    assert times_of(run, "sticks to the surface")
    rest = run.t > times_of(run, "sticks to")[-1]
    # m, the depth at which corners touch
    assert rest.any() and np.ptp(run.q[rest, 3:], axis=0).max() < 1e-9
    assert run.summary["energy_audit_max"] < 1e-9


def test_a_load_tips_over_on_a_deck_that_surges() -> None:
    """A tall load that friction holds on an accelerating deck tips as a block on a pivot."""
    half, tall, inertia, slip, duration = 0.5, 2.0, 1420.0, 2e-3, 0.5  # m, m, kg m², m/s, s
    # at once 4 m/s², of which it tips beyond 2.45
    surge = {"amplitude": 1.0, "frequency": 2.0, "phase": 0.5 * pi}
    contact = {
        "points": [[x, y, -2.0 * tall] for x in (half, -half) for y in (1.0, -1.0)],
        "motion": {"surge": surge},
    }
    payload = {"mass": MASS, "inertia": [1700.0, inertia, 420.0], "attachment": [0.0, 0.0, tall]}
    start, method = (
        {"position": [0.0, 0.0, FLOOR + tall]},
        {"method": "dop853", "rtol": 1e-8, "atol": 1e-10},
    )
    rough = contact | {"friction": 0.6, "slip_velocity": slip}
    run = crane_sim.simulate(scene(rough, start, duration, payload=payload, integrator=method))

    def rates(t: float, state: Any) -> tuple[float, float]:
        """Return the rates of the pitch [rad] about the edge and of its rate."""
        ahead, above = (
            tall * sin(state[0]) - half * cos(state[0]),
            half * sin(state[0]) + tall * cos(state[0]),
        )
        moment = MASS * (4.0 * cos(2.0 * t) * above + G * ahead)
        return state[1], moment / (inertia + MASS * (half**2 + tall**2))

    block = solve_ivp(rates, (0.0, duration), (0.0, 0.0), rtol=1e-10, atol=1e-12)
    crept = slip * duration  # m, at most: the edge creeps, slower than the slip velocity
    assert 2.0 * np.arcsin(run.q[-1, 8]) == pytest.approx(block.y[0, -1], abs=crept / tall)
    assert times_of(run, "leaves")[1] < 1e-3 and run.summary["energy_audit_max"] < 1e-9


def compliant(
    stiffness: float, damping: float, start: dict[str, Any], duration: float, **changes: Any
) -> Rollout:
    """Return the run of a load above springs."""
    contact = {"kind": "compliant", "stiffness": stiffness, "damping": damping}
    return crane_sim.simulate(scene(contact, start, duration, **changes))


def test_a_load_dropped_on_springs() -> None:
    """A load that falls on four springs at v stays for 2 (π - atan(v ω / g)) / ω, leaves at v."""
    drop, k = 0.2, 1e5
    speed, omega = sqrt(2.0 * G * drop), sqrt(4.0 * k / MASS)
    stay = 2.0 * (pi - atan(speed * omega / G)) / omega
    run = compliant(k, 0.0, {"position": [0, 0, FLOOR + 1.0 + drop]}, speed / G + stay + 0.05)
    touches, leaves = times_of(run, "touches"), times_of(run, "leaves")
    assert len(touches) == len(leaves) == 4
    assert touches[0] == pytest.approx(speed / G, rel=1e-9)
    assert leaves[-1] - touches[0] == pytest.approx(stay, rel=1e-9)
    assert run.v[-1, 5] == pytest.approx(speed - G * (run.t[-1] - leaves[-1]), rel=1e-8)
    assert run.summary["energy_audit_max"] < 1e-9


def test_damping_of_hunt_and_crossley() -> None:
    """Without gravity, speeds u before, w after satisfy c u - ln(1 + c u) = -c w - ln(1 - c w)."""
    u, c = 0.8, 0.7
    start = {"position": [0, 0, FLOOR + 1.01], "velocity": [0, 0, -u]}
    run = compliant(1e5, c, start, 0.4, gravity=0.0)
    w = float(run.v[-1, 5])
    assert 0.0 < w < u and times_of(run, "leaves")
    # the method's error
    assert c * u - log1p(c * u) == pytest.approx(-c * w - log1p(-c * w), rel=1e-8)
    assert run.summary["energy_audit_max"] < 1e-9
