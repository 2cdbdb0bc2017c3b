"""Predictions: what the library computes of their answers, and how a reader gives one."""

from typing import Any

import numpy as np
import pytest
from robust_slam.certificates import sdp
from robust_slam.consistency import pcm
from robust_slam.estimators import chi_square_threshold, gnc, irls
from robust_slam.estimators.graduation import gm_surrogate
from robust_slam.estimators.kernels import KERNELS
from robust_slam.estimators.loop import reweight
from robust_slam.fleet import rounds
from robust_slam.graphs import ate, dead_reckoning, pose_graph
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.groups import se2
from robust_slam.problems import LinearProblem, LocationProblem, PoseGraphProblem
from robust_slam_course import labs, pictures
from robust_slam_course.failures import outcome, town
from robust_slam_course.pictures.graphs import agreeing, with_wrong
from robust_slam_course.plots.landscapes import minima
from scipy.optimize import minimize

from tests.course.parity_graphs import Switches

C = chi_square_threshold(0.99, 3)
Array = np.ndarray[Any, Any]
Told = tuple[str, list[str]]
"""The right option's text, and phrases of the answers."""


def graph_of(data: dict[str, Any]) -> PoseGraph:
    """The graph that a picture gives to its script."""
    z = np.reshape(data["measurements"], (-1, 3))
    information = np.reshape(data["information"], (len(data["edges"]), 3, 3))
    trusted = np.array(data["trusted"], bool)
    return PoseGraph(len(data["truth"]) // 3, np.array(data["edges"]), z, information, trusted)


def misled(data: dict[str, Any], ends: list[int], size: int) -> PoseGraph:
    """The graph with wrong closures that agree."""
    truth = np.reshape(data["truth"], (-1, 3))
    return with_wrong(graph_of(data), *agreeing(truth, ends, size))[0]


def bent(graph: PoseGraph, spoiled: PoseGraph) -> Array:
    """Which edges change their residuals when the closures that come last join in."""
    norms = [
        pose_graph.residual_norms(each, PoseGraphProblem(each).initial())[: len(graph.edges)]
        for each in (graph, spoiled)
    ]
    return np.abs(norms[1] - norms[0]) > 0.005


def location(z: list[float], kernel: str, c: float, x0: float, sigma: float = 1.0) -> list[float]:
    """The estimates of a descent."""
    run = irls(LocationProblem(z, sigma), KERNELS[kernel](c), x0, tol=1e-4).history
    return [float(step.x) for step in run]


def opening(data: Any, state: Any) -> Told:
    graph = graph_of(data)
    moved = bent(graph, with_wrong(graph, state["wrong"])[0])
    right = "nearly all" if moved.mean() > 0.9 else "the path between"
    return right, [f"{moved.sum()} of the other {moved.size} edges"]


def cycles(data: Any, state: Any) -> Told:
    whole = graph_of(data)
    spoiled, is_outlier = with_wrong(whole, [state["wrong"]])
    driven = pose_graph.select(whole, whole.is_odometry)
    moved = bent(driven, pose_graph.select(spoiled, spoiled.is_odometry | is_outlier))
    assert moved.size == 99
    return f"{moved.sum()}", [f"{(~moved).sum()} steps are outside", f"the {moved.sum()} steps"]


def leverage(data: Any, state: Any) -> Told:
    place, c = state["held"], data["kernels"]["cauchy"]
    p, y = np.array(state["p"]), np.array(state["y"])
    wall = data["truth"][0] + data["truth"][1] * place
    pulls = []
    for high in np.linspace(0, 3, 61):
        y[place] = wall + high
        problem = LinearProblem(np.column_stack([np.ones(p.size), p]), y, data["sigma"])
        huber = irls(problem, KERNELS["huber"](data["kernels"]["huber"])).x
        line = irls(problem, KERNELS["cauchy"](c), huber).x
        pulls.append(float(KERNELS["cauchy"](c).psi(-problem.residuals(line)[place])))
    hardest = np.linspace(0, 3, 61)[np.argmax(pulls)]
    right = "about ½ m" if abs(hardest - 0.5) < 0.1 else f"{hardest} m"
    third = "less than a third" if pulls[-1] < max(pulls) / 3 else "more than a third"
    return right, [f"{c * data['sigma']:.2f} m above the fit", third]


def kernels(data: Any, state: Any) -> Told:
    names = ("squared", "huber", "cauchy", "tls")

    def end(z: float, name: str) -> float:
        return location([*data["inliers"], z], name, state["c"], 0.0)[-1]

    drifts = [[end(z, name) for z in np.arange(0.0, 15.5, 0.5)] for name in names]
    back = [drift[-1] < 0.5 * max(drift) for drift in drifts]
    mean, huber, cauchy, tls = (drift[-1] for drift in drifts)
    assert back == [False, False, True, True] and max(drifts[1]) < huber + 0.01
    said = f"Cauchy’s returns to {cauchy:.2f} and that of TLS to {tls:.0f}"
    return "two", [said, f"stops at {huber:.2f}, and the mean moves on to {mean:.2f}"]


def majoriser(data: Any, state: Any) -> Told:
    z, asked = data["readings"], pictures.majoriser().answer["start"]
    path = location(z, state["kernel"], data["c"], asked, state["sigma"])
    right = "near 0" if abs(path[-1]) < 0.1 else "near 5"
    assert round(float(np.mean(z))) == 1
    return right, [f"past {z[-1]:g} to {path[1]:.2f}"]


def basins(data: Any, state: Any) -> Told:
    z, start = [*[0.0] * 20, 10.0], state["start"]
    once, twice, thrice = (location(z, "tls", data["c"], start, k) for k in (1.0, 2.0, 3.0))
    assert once[-1] == twice[-1] == 10.0
    mean = f"{thrice[1]:.2f}"
    away = f"from there 10 is {10 - thrice[1]:.2f} away, beyond cσ = {3 * data['c']:g}"
    return f"{thrice[-1]:g}", [f"their mean, {mean}", away]


def annealing(data: Any, state: Any) -> Told:
    tried = {}
    for place in (6.0, 12.0, 30.0):
        z = [*state["z"][:-1], place]
        tried[place] = gnc(LocationProblem(z), data["c"], factor=state["factor"]).x
    (right,) = (place for place, x in tried.items() if abs(x - 6.0) < 0.1)
    means = {place: np.mean([*state["z"][:-1], place]) for place in tried}
    said = f"At 12 the mean, where the run begins, is {means[12.0]:.2f}; at 30"
    return f"{right:g}", [f"{said} it is {means[30.0]:g}"]


def hardening(data: Any, state: Any) -> Told:
    z, c, grid = np.array(state["z"]), data["c"], np.linspace(-4.0, 14.0, 211)
    run = gnc(LocationProblem(z), c, "gm", factor=state["factor"]).history
    counts = [minima(gm_surrogate(grid - z[:, None], c, s.mu).sum(axis=0)).size for s in run[1:]]
    solve = 1 + counts.index(2)
    before, after = run[solve - 1].x, run[solve].x
    assert set(counts[: solve - 1]) == {1} and run[solve].weights[-1] < 0.05
    return f"near {after:.1f}", [f"At solve {solve}, where", f"from {before:.2f} to {after:.2f}"]


def factors(data: Any, state: Any) -> Told:
    few, usual, many = (
        gnc(LocationProblem(state["z"]), data["c"], factor=factor)
        for factor in (2.0, state["factor"], 1.1)
    )
    assert round(usual.x) == 6
    lowest = min(step.x for step in few.history)
    return f"1.1 at {abs(many.x):.0f}, 2 at {few.x:.0f}", [f"never gets below {lowest:.2f}"]


def consistency(data: Any, state: Any) -> Told:
    kept = []
    for size in (9, 8, 7):
        largest = pcm(misled(data, state["group"], size), C).adjacency
        inliers = len(largest) - size
        assert largest[:inliers, :inliers].all() and largest[inliers:, inliers:].all()
        assert not largest[:inliers, inliers:].any()
        kept.append(inliers > size)
    return ("none", "one", "two")[kept.index(True)], []


def certificate(data: Any, state: Any) -> Told:
    edges, rest = np.array([[k, (k + 1) % 5] for k in range(5)]), np.radians(72 * np.arange(5))
    Q = sdp.connection_matrix(5, edges, np.broadcast_to(np.eye(2), (5, 2, 2)))

    def cost(angles: Any) -> float:
        R = np.hstack([se2.rotation([0, 0, t]) for t in angles])
        return float(np.trace(R @ Q @ R.T))

    def pulled(free: Any, turn: float) -> float:
        return cost([0, free[0], free[1], rest[3] + np.radians(turn), free[2]])

    small = 0.2 * np.random.default_rng(0).standard_normal((200, 5))
    lower = [cost(rest + turns) < cost(rest) for turns in [*small, *(0.2 * np.eye(5))]]
    free, falls = rest[[1, 2, 4]], []
    for turn in range(3, 91, 3):
        found = minimize(pulled, free, turn)
        free = found.x
        falls += [turn] if found.fun < cost(rest) else []
    assert not any(lower) and falls == [*range(falls[0], 91, 3)]
    return "only a large one", [f"beyond {falls[0]}°"]


def turning(data: Any, state: Any) -> Told:
    ring, equal = np.array([[0, 1], [1, 2], [2, 0]]), np.hstack([np.eye(2)] * 3)

    def spectrum(degrees: float, R: Array = equal) -> tuple[Array, float]:
        turn = np.tile(se2.rotation([0, 0, np.radians(degrees)]), (3, 1, 1))
        Q = sdp.connection_matrix(3, ring, turn)
        return sdp.dense_certificate(Q, R)[1], float(np.trace(R @ Q @ R.T))

    thirds = np.hstack([se2.rotation([0, 0, turn]) for turn in 2 * np.pi / 3 * np.arange(3)])
    right = max(turn for turn in range(91) if spectrum(turn)[0][0] > -1e-9)
    assert spectrum(right)[1] == pytest.approx(spectrum(right, thirds)[1])
    assert spectrum(right + 1)[1] > spectrum(right + 1, thirds)[1]
    _, *values = sorted(set(np.abs(spectrum(30)[0]).round(2)))
    return f"{right}°", ["0, {:.2f} and {:.2f}, each of them twice".format(*values)]


def ribbon(data: Any, start: str) -> str:
    """What each place of the diamond does to the map of GNC from a start."""
    letters, truth = "", np.reshape(data["truth"], (-1, 3))
    for place in range(len(truth) - 8):
        if abs(place - data["end"]) < 2:
            letters += "."
            continue
        graph = misled(data, [data["end"], place], 9)
        problem = PoseGraphProblem(graph, steps=1, tol=1e-6)  # as the picture
        x0 = problem.initial() if start == "squares" else dead_reckoning(graph)
        letters += "w" if ate(gnc(problem, C, x0=x0, tol=1e-4).x, truth) > 0.4 else "g"
    return letters


def showcase(data: Any, state: Any) -> Told:
    found = ribbon(data, "squares")
    assert pictures.showcase().answer["tried"] == {"gnc squares": found}
    lost = found.count("w")
    return "a quarter", [f"from {lost} of {lost + found.count('g')} places the nine win"]


def starts(data: Any, state: Any) -> Told:
    found = ribbon(data, "odometry")
    tried = {"gnc squares": ribbon(data, "squares"), "gnc odometry": found}
    assert pictures.starts().answer["tried"] == tried
    assert state["tried"].items() < tried.items() and found.count("w") == 1
    return "one", [f"Only from pose {found.index('w')}"]


def machine(data: Any, state: Any) -> Told:
    gyroscope, places, start = (dial["runs"] for dial in data["dials"])
    biased = gyroscope[data["dials"][0]["values"].index(0.04)]
    told = outcome("odometry")
    off = float(ate(told.poses, town()[2]))
    assert biased["certified"] and "m" not in biased["fates"][: data["inliers"]]
    assert all(run["certified"] for run in (*gyroscope, *places))
    assert not start[-1]["certified"] and max(run["off"] for run in places) > 1
    assert told.passed is not None
    lost = data["inliers"] - np.sum(told.passed & ~told.graph.is_odometry & ~told.is_outlier)
    return "none", [f"{lost} of the {data['inliers']} inliers", f"{off:.2f} m off"]


def graduation(data: Any, state: Any) -> Told:
    # A column is a start, which comes first, and a cost by IRLS or by GNC.
    columns = [noises[data["noises"].index(0.05)].count("") for noises in data["lost"]]
    odometry, squares = sum(columns[:4]), sum(columns[4:])
    plain, graduated = sum(columns[::2]), sum(columns[1::2])
    right = "the start" if odometry - squares > graduated - plain else "graduation"
    found = f"From odometry {odometry} maps are good, from least squares {squares}"
    return right, [found, f"of {odometry - squares} maps", f"one of {graduated - plain} ("]


def robots(data: Any, state: Any) -> Told:
    rejected, given = [], len(data["edges"])
    whole, _ = with_wrong(graph_of(data), state["wrong"])
    for count in range(3):
        # The wrong closures come first, as the script has them.
        left = set(range(given)) - set(data["withC"][count:])
        graph = pose_graph.rows_of(whole, [*range(given, len(whole.edges)), *sorted(left)])
        run = rounds.solve(graph, data["labels"], C, max_rounds=60, tol=1e-3).rounds
        rejected.append(run[-1].weights[0] == 0)
    return ("none", "one", "two")[rejected.index(True)], []


def arena(data: Any, state: Any) -> Told:
    runs, column = data["table"]["runs"], data["solvers"].index("GNC")
    off = {p: runs[f"random {p}"][column][2] for p in range(0, 100, 10)}
    graph, _, truth = labs.spoiled("random", 80)
    assert round(float(ate(gnc(graph, C).x, truth)), 2) == off[80]
    alike = [p for p in off if off[p] == off[0]]
    assert alike == [*range(0, max(alike) + 1, 10)] and max(alike) < 80
    said = f"{off[0]:.2f} m off, and at 80 % {off[80]:.2f} m"
    return f"{max(alike)} %", [said, f"With the {round(10 * 80 / 20)} outliers of 80 %"]


def growing(data: Any, state: Any) -> Told:
    graph = graph_of(data)
    changes = data["minds"][0]
    outlier = 1 << int(np.sum(~graph.is_odometry)) - 1
    gone = [p for p, kept in zip(changes[::2], changes[1::2], strict=True) if not kept & outlier]
    withdrawn = min(p for p in gone if p > state["arrives"])
    (closure,) = graph.edges[~graph.is_odometry & (graph.edges.max(axis=1) == withdrawn)]
    assert withdrawn - state["arrives"] == 12
    assert np.sum(graph.edges[~graph.is_odometry].max(axis=1) == 23) == 2
    return "when one contradicts it clearly", [f"from {closure[0]} to {closure[1]}, twelve"]


def proofs(data: Any, state: Any) -> Told:
    good, lost = (data["runs"]["gnc"][data["turns"].index(turns)] for turns in (0.0, 3.0))
    assert good["off"] <= 0.1 < lost["off"] and "x" not in good["signs"] + lost["signs"]
    assert any("x" in run["signs"] for run in data["runs"]["gnc"])
    assert all(run["off"] > 0.1 and "x" not in run["signs"] for run in data["runs"]["switches"])
    said = "three times every certificate succeeds, and the map is lost"
    return "not always", [said, "odometry all certificates succeed"]


def priors(data: Any, state: Any) -> Told:
    problem, odds = PoseGraphProblem(graph_of(data), steps=1), np.log(999)
    rule = Switches(np.full(len(data["outlier"]), C**2 + 2 * odds))
    found = reweight(problem, rule, problem.guess, tol=1e-6)
    lost = ate(found.x, np.reshape(data["best"], (-1, 3))) > 0.1
    said = f"of {odds:.0f} raise λ from {C**2:.0f} to {C**2 + 2 * round(odds):.0f}"
    return "yes" if lost else "no", [said]


def breaking(data: Any, state: Any) -> Told:
    count, _ = data["best"][f"{state['town']}:{state['solver']}"]
    inliers = data["towns"][state["town"]]["trusted"].count(0)
    told = ("none", "one", "two", "three", "four")
    said = f"{told[count].capitalize()} are enough, although there are"
    return told[count], [f"{said} {told[inliers]} inliers"]


@pytest.mark.parametrize("name", pictures.__all__)
@pytest.mark.long
def test_the_right_answer_and_its_reasons_are_what_the_library_computes(name):
    shown = getattr(pictures, name)()
    right, phrases = globals()[name](dict(shown.data), dict(shown.state))
    options = shown.question.options
    assert [option.text for option in options if option.correct] == [right]
    answers = "\n".join(option.answer for option in options)
    assert not [phrase for phrase in phrases if phrase not in answers], answers


@pytest.fixture(scope="module")
def card(tmp_path_factory):
    """The address of a page with one picture."""
    path = tmp_path_factory.mktemp("card") / "page.html"
    html = pictures.basins().static_html()
    path.write_text(f'<!doctype html><meta charset="utf-8">{html}', "utf-8")
    return path.as_uri()


SEEN = """form => [...form.querySelectorAll("label, legend, p")].filter((part) =>
  part.checkVisibility({visibilityProperty: true, opacityProperty: true}))
  .map((part) => part.innerText)"""
"""The texts of a prediction that can be seen."""
PROMPT = "Predict: From 8 this run ends at 10. Where does it end when σ is three times as large?"
ASKED = [PROMPT, "10", "0", "0.48, the mean"]
TRUTH = "At σ = 3 all 21 readings are within cσ = 9 of 8. From their mean, 0.48, the one at 10"


def move(page: Any) -> None:
    """Move the start, which tells nothing, then σ beyond 3, and wait for the verdict."""
    page.locator("[data-handle]").first.press("ArrowRight")
    page.wait_for_timeout(800)
    assert page.locator("[data-waits]").count()
    page.locator("[data-control=sigma]").press("End")
    page.wait_for_selector(".rs-predict:not([data-waits])")


@pytest.mark.browser
@pytest.mark.parametrize("scripts", [True, False])
@pytest.mark.parametrize("width", [390, 1280])
def test_each_answer_follows_a_move_and_shifts_nothing(scripts, width, card, open_page):
    viewport = {"width": width, "height": 800}
    page = open_page(card, java_script_enabled=scripts, viewport=viewport).page
    form, picture = page.locator(".rs-predict"), page.locator(".rs-picture")
    before = picture.bounding_box()
    assert form.evaluate(SEEN) == ASKED
    for place, chosen in enumerate(ASKED[1:]):
        form.locator("label").nth(place).click()
        if scripts:
            assert form.evaluate(SEEN)[1].startswith(f"You chose {chosen}. Find out below")
            move(page)
        [prompt, answer] = form.evaluate(SEEN)
        wrong = f"✗ You chose {chosen}. The answer is 0."
        opening = "✓ Right: 0." if chosen == "0" else wrong
        assert prompt == PROMPT and answer.startswith(opening)
        assert picture.bounding_box() == before
        if scripts:
            page.locator("[data-control=reset]").click()
        else:
            form.locator("input").nth(place).press("Space")
        assert form.evaluate(SEEN) == ASKED


@pytest.mark.browser
def test_it_is_answered_and_asked_again_by_keyboard_and_asked_on_paper(card, open_page):
    """Paper shows the picture three times, and afterwards the page is as it was."""
    page = open_page(card).page
    form = page.locator(".rs-predict")
    for key in ("Tab", "Tab", "Space"):
        page.keyboard.press(key)
    move(page)
    answer = form.evaluate(SEEN)[1]
    assert answer.startswith("✓ Right: 0.") and TRUTH in answer
    form.locator("input").nth(1).press("Enter")
    assert page.url == card and len(form.evaluate(SEEN)) == 2
    page.keyboard.press("Space")
    assert form.evaluate(SEEN) == ASKED
    picture = page.locator(".rs-picture")
    form.locator("label").nth(2).click()
    page.emulate_media(media="print")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert form.evaluate(SEEN) == ASKED
    told = picture.locator(".rs-paper figcaption").all_inner_texts()
    assert len(told) == 3 and told[0] != told[-1] and "ends at 0" in told[-1]
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert picture.locator(".rs-paper").count() == 0


@pytest.mark.browser
def test_a_finger_finds_44_pixels_of_all_that_can_be_pressed(card, open_page):
    phone = {"width": 390, "height": 844}
    page = open_page(card, has_touch=True, is_mobile=True, viewport=phone).page
    pressed = page.locator(".rs-picture").locator("button, input, select, summary")
    page.locator(".rs-folded").evaluate("more => { more.open = true; }")
    heights = pressed.evaluate_all(
        """all => all.filter((each) => each.checkVisibility()).map((each) => Math.max(
          each.offsetHeight, parseFloat(getComputedStyle(each, "::after").height) || 0))"""
    )
    assert len(heights) > 8 and min(heights) >= 44
