"""Laws of the overhead crane: the energy law's proof, LQR's poles, and unknown cables.

Both laws run on cables that they do not know.
"""

from dataclasses import replace
from math import sqrt
from typing import Any

import numpy as np
import pytest
from scipy.linalg import eig, eigvals, expm

import crane_sim
from crane_control import lqr
from crane_sim.simulation.linearisation import state_matrices
from crane_sim.simulation.rollout import simulate

G = 9.81
SAMPLED = {"law": "energy", "period": 0.01}
HOIST = {"hoist": {"drive": "force", "inertia": 5.0}, "reference": {"q": [3.0, 1.5]}}


def scene_of(links: int = 1, mass: float = 20.0, **groups: Any) -> crane_sim.Scene:
    """Return a scene of 10 kg on 2 m of cable whose laws assume one link.

    `groups` are merged over it.
    """
    document: dict[str, Any] = {
        "crane": "overhead",
        "duration": 20.0,
        "trolley": {"drive": "force", "mass": mass},
        "cable": {"lengths": [2.0 / links] * links, "node_masses": [0.1] * (links - 1) + [10.0]},
        "initial": {"angles": [0.2] * links},
        "reference": {"q": [3.0]},
        "control": SAMPLED,
    } | groups
    control, payload = document["control"], document["cable"]["node_masses"][-1]
    nominal = {"cable": {"lengths": [2.0], "node_masses": [payload]}, "initial": {"angles": [0.0]}}
    return crane_sim.load_scene(
        document | {"control": control | {"nominal": nominal}} if links > 1 else document
    )


LOOPS: dict[str, dict[str, Any]] = {
    "large swing": {"initial": {"angles": [1.3], "rates": [-2.0], "v": 1.0}},
    "far target": {"reference": {"q": [30.0]}, "control": {"reach": 1.0}},
    "hoist": HOIST,
}


@pytest.mark.parametrize(
    "loop",
    [pytest.param(name, marks=pytest.mark.slow) if name == "hoist" else name for name in LOOPS],
    ids=lambda name: name.replace(" ", "-"),
)
def test_v_only_falls_along_a_continuous_closed_loop(loop: str) -> None:
    """Along every continuous closed loop V never rises, and falls at the proof's rate."""
    groups = LOOPS[loop]
    control = {"law": "energy", "period": "continuous", **groups.get("control", {})}
    run = simulate(scene_of(**groups | {"control": control}), duration=10.0)
    value, rate = run.lyapunov().T
    assert np.all(rate <= 0.0)
    # the integrator's tolerance, where V stands still
    assert np.max(np.diff(value)) < 1e-9 * value[0]
    # Simpson's rule over 20 ms, error h^4 / 180 of the fourth derivative: of exp(-20 t), the
    # fastest, 1e-5
    fallen = np.cumsum((rate[:-2:2] + 4.0 * rate[1:-1:2] + rate[2::2]) * 0.01 / 3.0)
    assert np.allclose(value[2::2] - value[0], fallen, rtol=0, atol=1e-4 * value[0])


@pytest.mark.parametrize("hoist", [None, 9.0, 900.0], ids=["rope", "hoist", "hoist that sticks"])
def test_friction_lowers_v(hoist: float | None) -> None:
    """With joint friction V changes at the law's rate, by differences along accelerations.

    The accelerations are the crane's.

    A hoist at rest slips off below the force that its static friction of 9 N leaves, and sticks
    with 900 N.
    """
    rubs: dict[str, Any] = {"trolley": {"coulomb": 4.0, "static": 5.0, "viscous": 3.0}}
    rubs |= {"hoist": {"coulomb": 8.0, "static": hoist, "viscous": 2.0}} if hoist else {}
    scene, rng, h = (
        scene_of(friction=rubs, **(HOIST if hoist else {})),
        np.random.default_rng(5),
        1e-5,
    )
    law: Any = scene.law
    for k in range(6):
        q, v = (
            np.array([*rng.uniform(1.0, 3.0, len(scene.joint_names) - 1), 1.2]),
            rng.normal(0, 1, 3),
        )
        v = v[: len(q)]
        v[1] *= k % 2 if hoist else 1.0  # every other time the hoist rests
        a = crane_sim.acceleration(scene, q, v, law(0.0, tuple(q), tuple(v)))
        ahead, behind = (law.lyapunov(0.0, tuple(q + s * v), tuple(v + s * a))[0] for s in (h, -h))
        _, rate = law.lyapunov(0.0, tuple(q), tuple(v))
        # V of some 100 J: rounding 1e-14 / h, and h² of its third derivative
        assert (ahead - behind) / (2.0 * h) == pytest.approx(rate, rel=1e-7, abs=1e-7)
        assert rate < -law.kd * v[0] ** 2


@pytest.mark.parametrize("groups", [{}, HOIST], ids=["rope", "hoist"])
def test_the_trolley_feels_like_one_of_the_apparent_mass(groups: dict[str, Any]) -> None:
    """Under the law the crane accelerates as with a light trolley on springs and dampers."""
    scene, light = scene_of(**groups), scene_of(mass=2.5, **groups)
    law: Any = scene.law
    rng = np.random.default_rng(3)
    for _ in range(5):
        q, v = (
            np.array([*rng.uniform(1.0, 3.0, len(scene.joint_names) - 1), 1.2]),
            rng.normal(0, 1, 3),
        )
        v = v[: len(q)]
        demanded = law(0.0, tuple(q), tuple(v))
        push = law.kp * (3.0 - q[0]) - law.kd * v[0]
        actual = crane_sim.acceleration(scene, q, v, demanded)
        assert np.allclose(
            actual,
            crane_sim.acceleration(light, q, v, (push, *demanded[1:])),
            rtol=1e-12,
            atol=1e-12,
        )
        springs = [0.5 * law.kp * (3.0 - q[0]) ** 2]
        springs += [
            0.5 * law.rope.kp * (1.5 - q[1]) ** 2 + 10.0 * G * q[1] if groups else 10.0 * G * 2.0
        ]
        assert law.lyapunov(0.0, tuple(q), tuple(v))[0] == pytest.approx(
            crane_sim.energy(light, q, v) + sum(springs)
        )


def test_the_default_gains_put_all_poles_on_one_spot() -> None:
    """At the target trolley and swing have four poles at minus the pendulum's frequency.

    They are linearised there.
    """
    scene = scene_of()
    law: Any = scene.law
    q = np.array([3.0, 0.0])
    a, b = state_matrices(scene, q, np.zeros(1))
    steps = 1e-5 * np.eye(4)
    gain = [(law(0, q + d[:2], d[2:])[0] - law(0, q - d[:2], -d[2:])[0]) / 2e-5 for d in steps]
    omega = sqrt(G / 2.0)
    # coefficients, since a fourfold pole moves by the fourth root of an error; the law's
    # differences are good to 1e-9
    assert np.poly(a + b @ np.array([gain])) == pytest.approx(np.poly([-omega] * 4), rel=1e-7)


def cart_pendulum() -> tuple[np.ndarray, np.ndarray]:
    """Return A, B of (trolley, swing, rates): M x'' = F + m g a, l a'' = -x'' - g a."""
    heavy, m, length = 20.0, 10.0, 2.0
    a, b = np.zeros((4, 4)), np.zeros((4, 1))
    a[:2, 2:] = np.eye(2)
    a[2, 1], a[3, 1] = m * G / heavy, -(heavy + m) * G / (heavy * length)
    b[2:, 0] = 1.0 / heavy, -1.0 / (heavy * length)
    return a, b


@pytest.mark.parametrize("period", [None, 0.05], ids=["continuous", "sampled"])
def test_closed_loop_poles_are_those_of_the_hamiltonian(period: float | None) -> None:
    """LQR's poles are the stable eigenvalues of hand-written Hamiltonian matrices, or pencils."""
    q, r = np.diag([25.0, 400.0, 30.0, 90.0]), 0.002
    scene = scene_of(control={"law": "lqr", "q": np.diag(q).tolist(), "r": [r]})
    nominal = replace(scene, sampled=period is not None, period=period or 0.01)
    law = lqr.build({"q": np.diag(q).tolist(), "r": [r]}, nominal)
    a, b = cart_pendulum()
    eye, nil = np.eye(4), np.zeros((4, 4))
    if period is None:
        expected = eigvals(np.block([[a, -b @ b.T / r], [-q, -a.T]]))
        expected = expected[expected.real < 0.0]
    else:
        transition = expm(period * np.block([[a, b], [np.zeros((1, 5))]]))
        a, b = transition[:4, :4], transition[:4, 4:]
        expected = eig(
            np.block([[a, nil], [-q, eye]]), np.block([[eye, b @ b.T / r], [nil, a.T]]), right=False
        )
        expected = expected[np.abs(expected) < 1.0]
    # the law's matrices are differences, good to 1e-9; Riccati equations lose two or three digits
    # more
    assert np.sort_complex(law.poles) == pytest.approx(np.sort_complex(expected), rel=1e-6)


@pytest.mark.parametrize("force", [100.0])
def test_lqr_in_space_is_that_in_the_plane_of_a_steady_force(force: float) -> None:
    """Under a steady force along x, LQR in space holds the planar law's tilted link.

    It has the planar law's poles and gain.
    """
    steady = {"forces": [{"node": 1, "axis": "x", "force": {"kind": "constant", "value": force}}]}
    control = {"law": "lqr", "period": "continuous"}
    planar: Any = scene_of(**steady, control=control).law
    space = {
        "dimensions": 3,
        "bridge": {"drive": "force", "mass": 10.0},
        "initial": {"directions": [[0, 0, -1]]},
    }
    spatial: Any = scene_of(**steady, **space, control=control, reference={"q": [3.0, 1.0]}).law
    # to 1e-9 / ω², and as much of every second-order error below
    swing = np.arctan2(force, 10.0 * G)
    assert planar.target == pytest.approx([3.0, swing], abs=1e-8)
    assert spatial.target == pytest.approx([3.0, 1.0, np.sin(swing), 0.0, -np.cos(swing)], abs=1e-8)
    # differences of 1e-10 over what Riccati equations lose, see above
    assert all(np.abs(spatial.poles - pole).min() < 1e-6 * abs(pole) for pole in planar.poles)
    assert spatial.rows[0].effort == pytest.approx(planar.rows[0].effort, abs=1e-6)
    (kx, _, *k_link), (kv, _, *k_rate) = spatial.rows[0].gain.reshape(2, 5)
    tangent = np.array([np.cos(swing), 0.0, np.sin(swing)])
    assert [kx, k_link @ tangent, kv, k_rate @ tangent] == pytest.approx(
        planar.rows[0].gain, rel=1e-6
    )


@pytest.mark.slow
def test_lqr_holds_any_target() -> None:
    """The knuckle paper's weights bring the crane to its target in the times found elsewhere."""
    weights = [25, 400, 450, 200, 1, 1, 1, 1, 1, 1, 120, 120]
    control = {"law": "lqr", "period": "continuous", "q": weights, "r": [0.1, 0.1, 0.1, 1.0]}
    run = simulate(crane_sim.load_scene("knuckle_setpoint", {"control": control}))
    assert run.summary["peak_swing_deg"] < 10.0
    expected = {"slew": 19.4, "boom": 7.5, "jib": 8.2, "rope": 3.1}
    assert run.summary["settling_time"] == pytest.approx(expected, abs=0.06)  # given with one digit
    assert abs(np.array(run.q[-1, :4]) - run.scene.reference).max() < 1e-2


@pytest.mark.long(cases=["2-energy"])
@pytest.mark.parametrize("law", ["energy", "lqr"])
@pytest.mark.parametrize("links", [1, 2, pytest.param(10, marks=pytest.mark.slow)])
def test_laws_that_believe_in_one_link_work_on_more(law: str, links: int) -> None:
    """With one, two and ten links the payload arrives and stays.

    What is left are waves of the cable alone.
    """
    run = simulate(scene_of(links, control={"law": law, "period": 0.01}))
    late = run.t > 15.0
    # nine nodes of 0.1 kg on 10 kg, undamped: their waves of 0.1 rad and more move the payload by
    # 1e-3 of that
    assert np.abs(run.payload[late, 0] - 3.0).max() < (1e-4 if links == 1 else 2e-3)
    assert run.summary["settling_time"]["trolley"] < 6.0
    assert run.summary["min_rope_tension"] > 0.0
    k = 100  # the compiled loop and a call from Python are the same function
    assert run.scene.law is not None
    assert run.scene.law(run.t[k], tuple(run.q[k]), tuple(run.v[k])) == tuple(run.u[k])


@pytest.mark.parametrize(
    "name",
    [
        "overhead_lqr",
        pytest.param("overhead_lqr_chain", marks=pytest.mark.slow),
        pytest.param("overhead_hoist_energy", marks=pytest.mark.slow),
    ],
)
def test_the_catalogue_reaches_its_targets(name: str) -> None:
    """Every scene with a law ends on its target with the payload hanging still."""
    run = simulate(name)
    ten = name.endswith("chain")  # undamped waves of the cable remain, see above
    assert max(map(abs, run.summary["final_error"].values())) < (1e-3 if ten else 1e-6)
    assert run.summary["residual_swing_deg"] < (0.05 if ten else 1e-3)


LQR = {"law": "lqr"}
FIXED = {
    "trolley": {"drive": "fixed"},
    "hoist": {"drive": "force", "inertia": 5.0},
    "reference": {"q": [1.5]},
}


@pytest.mark.parametrize(
    ("groups", "message"),
    [
        (
            {**FIXED, "control": LQR},
            "a motion of 2.56 rad/s about the target stays: no effort damps it",
        ),
        (
            {"gravity": 0.0, "control": LQR},
            "a motion of 0 rad/s about the target stays: no effort damps it",
        ),
        ({"control": LQR | {"q": [0.0] * 4}}, "no effort damps it, or its states have no weight"),
        (
            {**HOIST, "reference": {"q": [3.0, 0.0]}, "control": LQR},
            "no efforts hold the crane at rest there",
        ),
        (
            {"trolley": {"drive": "fixed"}, "reference": {"q": []}, "control": LQR},
            "actuated are ()",
        ),
        ({"reference": None, "control": LQR}, "LQR needs a target"),
        (
            {"control": LQR | {"q": [1.0, 1.0]}},
            "control.q: has 2 weights, 4 are needed: of the positions, then",
        ),
        ({"reference": None}, "the energy law needs a target"),
        ({"gravity": 0.0}, "gravity = 0.0"),
        (FIXED, "the energy law drives both by force"),
        (
            {**HOIST, "reference": {"q": [3.0, -1.0]}},
            "reference.q[1] = -1.0: must be greater than 0",
        ),
        ({**HOIST, "control": SAMPLED | {"kp": [1.0]}}, "control.kp: has 1 values, 2 are needed"),
        (
            {
                "cable": {"lengths": [1.0, 1.0], "node_masses": [1.0, 9.0]},
                "initial": {"angles": [0, 0]},
            },
            "the energy law needs a nominal cable of one rigid link",
        ),
    ],
    ids=lambda case: str(case)[:40],
)
def test_what_a_law_cannot_do_is_a_single_line_error(groups: dict[str, Any], message: str) -> None:
    """Targets that cannot be held or reached, and bad settings: single-line errors, with key."""
    with pytest.raises(crane_sim.SceneError) as caught:
        scene_of(**groups)
    assert message in str(caught.value) and "\n" not in str(caught.value)
