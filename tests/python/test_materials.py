"""Materials and force fields that are written in Python."""

import gc
import json
import weakref

import numpy as np
import pytest

import tetraction as tt

MU, LAMBDA = 4e4, 6e4


def neo_hookean_energy(F):
    J = np.linalg.det(F)
    return (0.5 * MU * (np.einsum("nij,nij->n", F, F) - 3 - 2 * np.log(J))
            + 0.5 * LAMBDA * np.log(J) ** 2)  # fmt: skip


def neo_hookean_stress(F):
    inverse = np.linalg.inv(F).transpose(0, 2, 1)
    log = np.log(np.linalg.det(F))[:, None, None]
    return MU * (F - inverse) + LAMBDA * log * inverse


def neo_hookean_stiffness(F):
    inverse = np.linalg.inv(F).transpose(0, 2, 1)
    log = np.log(np.linalg.det(F))[:, None, None, None, None]
    one = np.eye(3)
    return (MU * np.einsum("ik,JL->iJkL", one, one)[None]
            + (MU - LAMBDA * log) * np.einsum("niL,nkJ->niJkL", inverse, inverse)
            + LAMBDA * np.einsum("niJ,nkL->niJkL", inverse, inverse))  # fmt: skip


def neo_hookean(**changed):
    functions = {"energy": neo_hookean_energy, "stress": neo_hookean_stress,
                 "stiffness": neo_hookean_stiffness, **changed}  # fmt: skip
    return tt.CustomMaterial(**functions, mu=MU, lambda_=LAMBDA, density=1000.0, name="mine")


@pytest.mark.parametrize("integrator", ["explicit", "verlet", "midpoint", "energy-momentum"])
@pytest.mark.parametrize("element", ["linear", "quadratic"])
def test_a_law_written_in_python_moves_as_the_built_in_one(beam, integrator, element):
    beam.time.integrator = integrator
    beam.mesh.element = element
    beam.time.step, beam.time.end = (5e-4, 0.02) if element == "quadratic" else (1e-3, 0.05)
    beam.material = tt.Material(model="neo-hookean", mu=MU, density=1000.0, **{"lambda": LAMBDA})
    plain = tt.run(beam)
    beam.material = neo_hookean()
    custom = tt.run(beam)
    assert plain.status == custom.status == "ok"
    moved = abs(plain.displacements).max()
    assert moved > 1e-4
    assert abs(custom.positions - plain.positions).max() < 1e-8 * moved
    assert custom.balance["max_relative_energy_drift"] == pytest.approx(
        plain.balance["max_relative_energy_drift"], rel=0.02, abs=1e-12)


def test_the_functions_are_called_for_many_elements_at_once(beam):
    sizes = []

    def stress(F):
        sizes.append(len(F))
        return neo_hookean_stress(F)

    beam.time.integrator, beam.time.step = "explicit", 1e-4
    beam.material = neo_hookean(stress=stress)
    session = tt.Session(beam)
    sizes.clear()
    session.step(10)
    assert set(sizes) == {96} and len(sizes) <= 11


def test_static_and_modes_of_a_law_written_in_python(beam):
    beam.material = tt.Material(model="neo-hookean", mu=MU, density=1000.0, **{"lambda": LAMBDA})
    expected = tt.static(beam).positions, tt.modes(beam, 3).frequencies
    beam.material = neo_hookean()
    assert np.allclose(tt.static(beam).positions, expected[0], rtol=0, atol=1e-8)
    assert np.allclose(tt.modes(beam, 3).frequencies, expected[1], rtol=1e-9)


def test_regions_have_laws_of_their_own(beam):
    upper = {"box": {"min": [0, 0.1, -1], "max": [1, 1, 1]}}
    keys = {"model": "neo-hookean", "mu": MU, "lambda": LAMBDA, "density": 500.0}
    beam.time.end = 0.02
    beam.material_region = [tt.MaterialRegion(select=upper, **keys)]
    plain = tt.run(beam)
    law = neo_hookean()
    law.density = 500.0
    beam.material_region = [tt.MaterialRegion(select=upper, material=law)]
    custom = tt.run(beam)
    assert plain.masses.sum() == custom.masses.sum() == pytest.approx(30.0)
    assert np.allclose(custom.positions, plain.positions, rtol=0, atol=1e-9)
    with pytest.raises(tt.InputError, match="program"):
        beam.to_toml()


def test_wrong_derivatives_are_refused():
    with pytest.raises(tt.InputError, match="stress differs from the derivative of the energy"):
        neo_hookean(stress=lambda F: 1.001 * neo_hookean_stress(F))
    with pytest.raises(tt.InputError, match="stiffness differs from the derivative of the stress"):
        neo_hookean(stiffness=lambda F: neo_hookean_stiffness(F).transpose(0, 2, 1, 3, 4))
    with pytest.raises(tt.InputError, match=r"shape \(7, 3, 3\)"):
        neo_hookean(stress=lambda F: neo_hookean_stress(F)[:, 0])
    with pytest.raises(tt.InputError, match="mine"):
        tt.CustomMaterial(neo_hookean_energy, neo_hookean_stress, neo_hookean_stiffness, mu=-1.0,
                          lambda_=1.0, name="mine")  # fmt: skip


def test_an_exception_of_a_law_passes_through_and_leaves_the_state(beam):
    state = {"fail": False}

    def stress(F):
        if state["fail"]:
            raise ZeroDivisionError("in my law")
        return neo_hookean_stress(F)

    beam.material = neo_hookean(stress=stress)
    session = tt.Session(beam)
    session.step(3)
    before = session.positions.copy()
    state["fail"] = True
    with pytest.raises(ZeroDivisionError, match="in my law"):
        session.step()
    assert np.array_equal(session.positions, before) and session.step_number == 3
    state["fail"] = False
    assert session.step(2) == 2


def test_a_law_can_be_changed_during_a_run(beam):
    session = tt.Session(beam)
    session.step(5)
    session.apply(tt.SetMaterial(custom=neo_hookean()))
    assert session.step(5) == 5


def test_laws_by_themselves():
    F = np.eye(3) + 0.1 * np.random.default_rng(1).standard_normal((20, 3, 3))
    keys = {"model": "neo-hookean", "mu": MU, "lambda": LAMBDA}
    energy = tt.material.energy_density(F, **keys)
    expected = neo_hookean_energy(F) - neo_hookean_energy(np.eye(3)[None])
    assert np.allclose(energy, expected, rtol=1e-12)
    assert np.allclose(tt.material.stress(F, **keys), neo_hookean_stress(F), rtol=1e-12)
    assert np.allclose(tt.material.stiffness(F, **keys), neo_hookean_stiffness(F), rtol=1e-12)
    one = tt.material.cauchy_stress(F[0], **keys)
    assert one.shape == (3, 3) and np.allclose(one, one.T)
    with pytest.raises(tt.InputError, match="not defined"):
        tt.material.stress(np.diag([-1.0, 1, 1]), **keys)
    with pytest.raises(tt.InputError, match="shape"):
        tt.material.stress(np.eye(2), **keys)


def test_a_force_field(beam):
    k = np.array([30.0, 50.0, 70.0])
    field = tt.ForceField(
        energy=lambda m, q: 0.5 * m * (q**2 @ k),
        gradient=lambda m, q: m[:, None] * q * k,
        hessian=lambda m, q: m[:, None, None] * np.diag(k),
        name="trap",
    )
    beam.force_field.append(field)
    beam.environment = {}
    for integrator in ("explicit", "midpoint"):
        beam.time.integrator, beam.time.step = integrator, 5e-4
        session = tt.run(beam)
        assert session.status == "ok"
        energy = 0.5 * (session.masses @ (session.positions**2 @ k))
        assert session.energies["trap"] == pytest.approx(energy)
        assert session.history["trap_energy"][-1] == session.energies["trap"]
        assert session.balance["max_relative_energy_drift"] < 1e-2
    with pytest.raises(tt.InputError, match="lower-case"):
        tt.ForceField(None, None, None, name="My field")


def test_the_summary_of_a_run_names_the_material(beam, tmp_path):
    beam.material = neo_hookean()
    tt.run(beam, tmp_path)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["scene"]["material"] == {"model": "mine", "density": 1000.0}


def test_damping_ratio_of_a_law_written_in_python(beam):
    beam.damping = {"ratio": {"at": [1.5, 10.0], "value": [0.02, 0.05]}}
    beam.material = tt.Material(model="neo-hookean", mu=MU, density=1000.0, **{"lambda": LAMBDA})
    expected = tt.modes(beam, 4).damping_ratios
    beam.material = neo_hookean()
    assert np.allclose(tt.modes(beam, 4).damping_ratios, expected, rtol=1e-8)
    assert beam.to_dict()["material"] == {"model": "mine", "density": 1000.0}


def test_keys_cannot_change_a_law_written_in_python(beam):
    beam.material = neo_hookean()
    session = tt.Session(beam)
    for edit in (tt.SetMaterial(youngs_modulus=2e6), tt.Set({"material.mu": 1e4})):
        with pytest.raises(tt.InputError, match="written in Python"):
            session.apply(edit)
    session.apply(tt.SetMaterial(model="neo-hookean", mu=2 * MU, **{"lambda": LAMBDA}))
    session.apply(tt.SetMaterial(mu=MU))
    session.step(3)
    beam.material = tt.Material(model="neo-hookean", mu=MU, density=1000.0, **{"lambda": LAMBDA})
    other = tt.Session(beam)
    other.step(3)
    assert abs(session.positions - other.positions).max() < 1e-10
    with pytest.raises(tt.InputError, match="either"):
        tt.SetMaterial(custom=neo_hookean(), mu=3.0)


@pytest.mark.parametrize("changed, what", [
    ({"stress": lambda F: np.nan * neo_hookean_stress(F)}, "finite"),
    ({"energy": lambda F: np.full(len(F), neo_hookean_energy(F).sum())}, "at once"),
    ({"stiffness": lambda F: neo_hookean_stiffness(F[:1])}, "shape"),
])  # fmt: skip
def test_functions_that_mix_elements_are_refused(changed, what):
    with pytest.raises(tt.InputError, match=what):
        neo_hookean(**changed)


def test_parameters_of_another_size_are_refused():
    with pytest.raises(tt.InputError, match="same order"):
        tt.CustomMaterial(neo_hookean_energy, neo_hookean_stress, neo_hookean_stiffness, mu=1e6 * MU,
                          lambda_=LAMBDA)  # fmt: skip


def test_a_field_with_a_wrong_sign_is_refused(beam):
    k = 5.0
    functions = [lambda m, q: 0.5 * k * q[:, 2] ** 2, lambda m, q: np.stack([0 * m, 0 * m, k * q[:, 2]], axis=1),
                 lambda m, q: np.tile(np.diag([0, 0, k]), (len(m), 1, 1))]  # fmt: skip
    beam.force_field = tt.ForceField(*functions, name="floor")
    tt.Session(beam)
    wrong = [functions[0], lambda m, q: -functions[1](m, q), functions[2]]
    beam.force_field = [tt.ForceField(*wrong, name="floor")]
    with pytest.raises(tt.InputError, match="gradient is not the derivative"):
        tt.Session(beam)


def test_a_law_cannot_use_its_own_session(beam):
    sessions = []

    def stress(F):
        if sessions:
            sessions[0].checkpoint()
        return neo_hookean_stress(F)

    beam.material = neo_hookean(stress=stress)
    sessions.append(tt.Session(beam))
    with pytest.raises(tt.InputError, match="its own session"):
        sessions[0].step()
    del sessions[:]


def test_functions_that_refer_to_their_session_are_collected(beam):
    """The law, the field and an edit of a session know the session, which Python can see and collect."""
    alive = []

    def make():
        known = {}

        def energy(F):
            known.get("session")
            return neo_hookean_energy(F)

        zero = (lambda m, q: np.zeros(len(m)), lambda m, q: np.zeros((len(m), 3)),
                lambda m, q: np.zeros((len(m), 3, 3)))  # fmt: skip
        beam.material = neo_hookean(energy=energy)
        beam.force_field = [tt.ForceField(lambda m, q: zero[0](m, q) * len(known), *zero[1:])]
        session = known["session"] = tt.Session(beam)
        session.step(2)
        session.apply(tt.SetMaterial(custom=neo_hookean(energy=lambda F: energy(F))))
        session.step(2)
        alive.append(weakref.ref(session))

    make()
    beam.material, beam.force_field = tt.Material(), []
    gc.collect()
    assert alive[0]() is None


def test_a_law_lives_as_long_as_it_is_used(beam):
    """Nobody but the session keeps it, also when a checkpoint of another session brings it."""
    beam.material = neo_hookean()
    first, second = tt.Session(beam), tt.Session(beam)
    first.apply(tt.SetMaterial(custom=neo_hookean()))
    beam.material = tt.Material()
    first.step(3)
    second.restore(first.checkpoint())
    expected = first.step(3), first.positions.copy()
    del first
    gc.collect()
    assert second.step(3) == expected[0]
    assert np.array_equal(second.positions, expected[1])


def graded(mu_of, lam=LAMBDA):
    """A neo-Hookean law whose μ depends on the place."""
    one = np.eye(3)

    def parts(F, *place):
        G = np.linalg.inv(F).transpose(0, 2, 1)
        return mu_of(*place), G, np.log(np.linalg.det(F))

    def energy(F, *place):
        mu, _, log = parts(F, *place)
        return 0.5 * mu * (np.einsum("nij,nij->n", F, F) - 2 * log) + 0.5 * lam * log**2  # not 0 at rest

    def stress(F, *place):
        mu, G, log = parts(F, *place)
        return mu[:, None, None] * (F - G) + lam * log[:, None, None] * G

    def stiffness(F, *place):
        mu, G, log = parts(F, *place)
        return (np.einsum("n,ik,JL->niJkL", mu, one, one)
                + np.einsum("n,niL,nkJ->niJkL", mu - lam * log, G, G)
                + lam * np.einsum("niJ,nkL->niJkL", G, G))  # fmt: skip

    return {"energy": energy, "stress": stress, "stiffness": stiffness}


def graded_law(mu_of, **changed):
    return tt.CustomMaterial(**{**graded(mu_of), **changed}, mu=MU, lambda_=LAMBDA, with_places=True, name="graded")


@pytest.mark.parametrize("integrator", ["explicit", "midpoint", "energy-momentum"])
@pytest.mark.parametrize("element", ["linear", "quadratic"])
def test_a_law_by_element_moves_as_regions_do(beam, integrator, element):
    beam.time.integrator = integrator
    beam.mesh.element = element
    beam.time.step, beam.time.end = 5e-4, 0.02
    keys = {"model": "neo-hookean", "lambda": LAMBDA, "density": 1000.0}
    beam.material = tt.Material(mu=MU, **keys)
    beam.material_region = [tt.MaterialRegion(select={"box": {"min": [0.5, -1, -1], "max": [2, 1, 1]}}, mu=3 * MU, **keys)]
    plain = tt.run(beam)
    beam.material_region = []
    corners = plain.rest_positions[plain.tetrahedra[:, :4]].mean(axis=1)
    own = np.where(corners[:, 0] > 0.5, 3 * MU, MU)  # data of each element
    for law in (graded_law(lambda element, position: own[element]),
                graded_law(lambda element, position: np.where(position[:, 0] > 0.5, 3 * MU, MU))):  # fmt: skip
        beam.material = law
        placed = tt.run(beam)
        assert placed.status == plain.status == "ok"
        moved = abs(plain.displacements).max()
        assert abs(placed.positions - plain.positions).max() < 1e-8 * moved
        assert placed.history["elastic_energy"][-1] == pytest.approx(plain.history["elastic_energy"][-1])
    assert np.allclose(tt.modes(beam, 3).frequencies[:1], tt.modes(beam, 1).frequencies)


def test_positions_are_those_of_the_quadrature_points(beam):
    seen = {}

    def modulus(element, position):
        assert element.dtype == np.int64 and position.shape == (len(element), 3)
        for e, x in zip(element, position):
            seen.setdefault(int(e), []).append(x)
        return np.full(len(element), MU)

    for kind, count in (("linear", 1), ("quadratic", 4)):
        beam.mesh.element = kind
        beam.material = graded_law(modulus)
        session = tt.Session(beam)
        seen.clear()
        session.element_fields()
        centres = session.rest_positions[session.tetrahedra[:, :4]].mean(axis=1)
        assert sorted(seen) == list(range(96))
        for e, positions in seen.items():
            found = np.unique(np.round(positions, 12), axis=0)
            assert len(found) == count
            assert np.allclose(found.mean(axis=0), centres[e], atol=1e-11)


def test_a_wrong_law_with_places_is_refused_when_a_body_is_made(beam):
    right = graded(lambda element, position: MU * (1 + position[:, 0]))
    tests = [
        ({"stress": lambda F, *at: 1.001 * right["stress"](F, *at)}, "stress differs"),
        ({"stiffness": lambda F, *at: right["stiffness"](F, *at).transpose(0, 2, 1, 3, 4)}, "stiffness differs"),
        ({"energy": lambda F, *at: right["energy"](F, *at) / 0.0}, "not defined at rest"),
        ({"stress": lambda F, *at: right["stress"](F, *at)[:, 0]}, "shape"),
        ({"stiffness": lambda F, *at: right["stiffness"](F, at[0], at[1][::-1])}, "at once"),
    ]
    for changed, message in tests:
        law = tt.CustomMaterial(**{**right, **changed}, mu=MU, lambda_=LAMBDA, with_places=True)
        with np.errstate(all="ignore"), pytest.raises(tt.InputError, match=message):
            beam.material = law
            tt.Session(beam)
    session = tt.Session(tt.Scene(mesh=beam.mesh, material=tt.Material(model="neo-hookean", youngs_modulus=1e5, poissons_ratio=0.3)))
    with pytest.raises(tt.InputError, match="shape"):
        session.apply(tt.SetMaterial(custom=tt.CustomMaterial(
            **{**right, **tests[3][0]}, mu=MU, lambda_=LAMBDA, with_places=True)))  # fmt: skip
    with pytest.raises(tt.InputError, match="stress differs"):
        beam.material = tt.CustomMaterial(**{**right, **tests[0][0]}, mu=MU, lambda_=LAMBDA, with_places=True)
        tt.modes(beam, 2)


def test_fibres_that_bear_no_compression_are_no_false_alarm(beam):
    """Their stiffness jumps at rest, where the derivatives are compared, too."""
    a, k = np.array([1.0, 0.0, 0.0]), 3e4

    def strain(F):
        d = F @ a
        return (d**2).sum(axis=1) - 1, d

    def energy(F):
        return neo_hookean_energy(F) + 0.5 * k * np.maximum(strain(F)[0], 0) ** 2

    def stress(F):
        e, d = strain(F)
        return neo_hookean_stress(F) + 2 * k * np.einsum("n,ni,J->niJ", np.maximum(e, 0), d, a)

    def stiffness(F, factor=1.0, at_the_jump=True):
        e, d = strain(F)
        is_taut = e >= 0 if at_the_jump else e > 0
        fibres = (4 * np.einsum("ni,J,nk,L->niJkL", d, a, d, a)
                  + 2 * np.einsum("n,ik,J,L->niJkL", e, np.eye(3), a, a))  # fmt: skip
        return neo_hookean_stiffness(F) + factor * k * is_taut[:, None, None, None, None] * fibres

    for at_the_jump in (True, False):
        law = neo_hookean(energy=energy, stress=stress, stiffness=lambda F, c=at_the_jump: stiffness(F, 1.0, c))
        beam.material = law
        assert tt.run(beam).balance["max_relative_energy_drift"] < 1e-2
    with pytest.raises(tt.InputError, match="stiffness differs"):
        neo_hookean(energy=energy, stress=stress, stiffness=lambda F: stiffness(F, 1.01))


def pushing_floor(k, height, factor=1.0):
    """U = ½ k ⟨height − z⟩²."""
    def depth(q):
        return np.minimum(q[:, 2] - height, 0)

    return tt.ForceField(
        lambda m, q: 0.5 * k * depth(q) ** 2,
        lambda m, q: np.stack([0 * m, 0 * m, k * depth(q)], axis=1),
        lambda m, q: factor * k * (depth(q) < 0)[:, None, None] * np.diag([0, 0, 1.0]),
        name="floor")


def test_a_floor_that_only_pushes_is_no_false_alarm(cube):
    """Half of the vertices lie exactly on it, where its second derivative jumps."""
    points, tetrahedra = cube
    flat = tt.Scene(material=tt.Material(model="neo-hookean", youngs_modulus=1e5, poissons_ratio=0.3),
                    time={"integrator": "midpoint", "step": 1e-3, "end": 0.1})  # fmt: skip
    for height in (0.0, 1.0, 0.5):
        flat.force_field = [pushing_floor(1e4, height)]
        tt.Session(flat, points, tetrahedra)
    flat.force_field = [pushing_floor(1e4, 1.5, factor=1.1)]
    with pytest.raises(tt.InputError, match="hessian is not the derivative"):
        tt.Session(flat, points, tetrahedra)


def barrier(height, kappa, thickness, **domain):
    """U = −κ (d − d̂)² ln(d/d̂) for heights d < d̂ above the floor (Li et al. 2020), infinite at d = 0."""
    def parts(q):
        d = q[:, 2] - height
        inside = d < thickness
        d = np.where(inside, d, thickness)
        assert (d > 0).all(), "called where U is not defined"
        return d, d - thickness, np.log(d / thickness), inside

    def energy(m, q):
        d, gap, log, _ = parts(q)
        return -kappa * gap**2 * log

    def gradient(m, q):
        d, gap, log, _ = parts(q)
        return np.stack([0 * m, 0 * m, -kappa * gap * (2 * log + gap / d)], axis=1)

    def hessian(m, q):
        d, gap, log, _ = parts(q)
        return (-kappa * (2 * log + 4 * gap / d - (gap / d) ** 2))[:, None, None] * np.diag([0, 0, 1.0])

    return tt.ForceField(energy, gradient, hessian, name="floor", **domain)


def domain_above(height):
    def fraction(q, d):
        with np.errstate(all="ignore"):
            return np.where(d[:, 2] < 0, (height - q[:, 2]) / d[:, 2], np.inf)

    return {"defined": lambda q: q[:, 2] > height, "admissible_fraction": fraction}


@pytest.mark.parametrize("integrator", ["verlet", "midpoint", "energy-momentum"])
def test_a_field_with_a_domain_is_never_asked_outside(cube, integrator):
    points, tetrahedra = cube
    scene = tt.Scene(
        material=tt.Material(model="neo-hookean", youngs_modulus=1e6, poissons_ratio=0.3, density=1000.0),
        environment={"kind": "gravity", "direction": [0, 0, -1]},
        time={"integrator": integrator, "step": 1e-4 if integrator == "verlet" else 1e-3, "end": 0.3},
        initial={"velocity": [0, 0, -2.0]},
        force_field=[barrier(-0.1, 1e5, 0.05, **domain_above(-0.1))])  # fmt: skip
    lowest = []
    session = tt.run(scene, points=points, tetrahedra=tetrahedra,
                     observers=lambda s: lowest.append(s.positions[:, 2].min()))  # fmt: skip
    assert session.status == "ok"
    assert -0.1 < min(lowest) < -0.06  # it has hit the floor
    assert session.balance["max_relative_energy_drift"] < 0.05
    # A body that begins outside is refused, and so is a way that is no number.
    scene.initial.velocity = [0, 0, 0]
    scene.force_field = [barrier(0.5, 1e5, 0.05, **domain_above(0.5))]
    with pytest.raises(tt.InputError, match="floor"):
        tt.Session(scene, points, tetrahedra)
    if integrator != "verlet":
        domain = domain_above(-0.1)
        domain["admissible_fraction"] = lambda q, d: np.full(len(q), np.nan)
        scene.force_field = [barrier(-0.1, 1e5, 0.05, **domain)]
        with pytest.raises(tt.InputError, match="NaN"):
            tt.run(scene, points=points, tetrahedra=tetrahedra)
