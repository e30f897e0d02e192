"""A case, its solution with two settings, and the record of both."""

import copy
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from extrapolation import Setting, Walk
from rigid import Real, Rigid, Vector

TIGHT, LOOSE = Setting(9, 1e-16), Setting(7, 3e-15)


@dataclass
class Case:
    """What is solved: description, instants [s], start, and systems up to given instants."""

    spec: dict[str, Any]
    times: list[float]
    nodes: Vector  # (N + 1, axes), the trolley first
    velocities: Vector
    phases: list[tuple[float, Rigid]]
    settings: tuple[Setting, Setting] = (TIGHT, LOOSE)
    winch: list[float] = field(default_factory=list)  # length and rate of a winch with inertia

    def start(self) -> Vector:
        """Return the first state."""
        halves = zip((self.nodes, self.velocities), self.winch or (0.0, 0.0), strict=True)
        return np.concatenate([self.phases[0][1].join(half, Real(value)) for half, value in halves])


@dataclass
class Course:
    """A solution at the instants of its case: states, tensions, and its events."""

    states: list[Vector] = field(default_factory=list)
    tensions: list[Vector] = field(default_factory=list)
    events: list[tuple[float, list[int]]] = field(default_factory=list)


def solve_case(case: Case, setting: Setting) -> Course:
    """Return the course of a case; its systems are left as they were."""
    course, walk = Course(), Walk(0.0, case.start(), setting)
    for end, system in copy.deepcopy(case.phases):
        stops = [t for t in case.times if float(walk.t) < t <= end]
        for stop in stops if end in stops else [*stops, end]:
            while walk.advance(system.field, Real(stop), system.project, system.event):
                walk.y, what = system.switch(walk.t, walk.y)
                walk.length = Real(1e-4)
                course.events.append((float(walk.t), what))
            if stop in stops:
                course.states.append(walk.y)
                course.tensions.append(system.tension(walk.t, walk.y))
        walk.length = Real(1e-4)
    return course


def world(points: Vector) -> Vector:
    """Return points (..., axes) as (..., 3) in x, y, z with z up."""
    return (
        points
        if points.shape[-1] == 3
        else np.stack([points[..., 0], 0 * points[..., 0], points[..., 1]], axis=-1)
    )


def views(case: Case, course: Course) -> tuple[Vector, Vector, Vector]:
    """Return nodes and velocities (K, N + 1, 3), and what follows: a winch's length and rate."""
    system = case.phases[0][1]
    halves = [[system.split(half) for half in np.split(y, 2)] for y in course.states]
    nodes, rates = (world(np.array([half[i][0] for half in halves])) for i in range(2))
    return nodes, rates, np.array([[half[0][1], half[1][1]] for half in halves])


def listed(values: Vector) -> list[Any]:
    """Return nested lists of doubles."""
    return (np.asarray(values).astype(float) + 0.0).tolist()  # no negative zeros


def record(case: Case) -> dict[str, Any]:
    """Return what is stored of a case: the tight solution and its distance from the loose one."""
    tight, loose = (solve_case(case, setting) for setting in case.settings)
    (nodes, rates, winch), (others, *_) = views(case, tight), views(case, loose)
    found: dict[str, Any] = {
        "spec": case.spec,
        "t": case.times,
        "node_positions_xyz": listed(nodes[:, 1:]),
    }
    found |= {
        "node_velocities_xyz": listed(rates[:, 1:]),
        "x": listed(nodes[:, 0, 0]),
        "xdot": listed(rates[:, 0, 0]),
    }
    if case.nodes.shape[1] == 3:
        found |= {"y": listed(nodes[:, 0, 1]), "ydot": listed(rates[:, 0, 1])}
    if case.winch:
        found |= {"l1": listed(winch[:, 0]), "l1dot": listed(winch[:, 1])}
    found["tension"] = listed(np.array(tight.tensions))
    if tight.events:
        found |= {
            "event_times": [t for t, _ in tight.events],
            "modes_after_event": [m[0] for _, m in tight.events],
        }
        found["agreement_events_s"] = max(
            abs(a - b) for (a, _), (b, _) in zip(tight.events, loose.events, strict=True)
        )
    return found | agreement(nodes, others)


def agreement(nodes: Vector, others: Vector) -> dict[str, Any]:
    """Return how far two solutions (K, ..., 3) [m] are apart, and the stored one's error bound."""
    apart = np.max(np.abs(nodes - others), axis=(1, 2)).astype(float)
    found = {"agreement_each_m": listed(apart), "agreement_m": float(np.max(apart))}
    # a stored double is rounded to 1.1e-16 of its value, and the initial data of any other program
    # are doubles too
    return found | {"trusted_abs_error_m": max(float(np.max(apart)), 1e-15)}


def store(target: Path, name: str, found: dict[str, Any]) -> None:
    """Put one case into a file, one line each."""
    known = json.loads(target.read_text()) if target.exists() else {}
    known[name] = found
    lines = [
        f"{json.dumps(key)}: {json.dumps(known[key], separators=(',', ':'))}"
        for key in sorted(known)
    ]
    target.write_text("{\n" + ",\n".join(lines) + "\n}\n")
