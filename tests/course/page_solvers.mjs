// Runs a solver of the page on cases from standard input and prints what it returns.
//
// Input: { solver, cases: [case, …] }, output: [answer, …]. Each case and answer is plain JSON.
import { readFileSync, readdirSync } from "node:fs";

const given = JSON.parse(readFileSync(0, "utf8"));
const course = new URL("../../lib/course/robust_slam_course/", import.meta.url);
const folder = new URL("canvas/js/solve/", course);
const page = { ...await import(new URL("pictures/breaking/attack.js", course)) };
for (const name of readdirSync(folder).filter((file) => file.endsWith(".js"))) {
  Object.assign(page, await import(new URL(name, folder)));
}

const PROBLEMS = {
  location: ({ z, sigma }) => page.locationProblem(z, sigma),
  line: ({ p, y, sigma }) => page.lineProblem(p, y, sigma),
  graph: ({ graph, guess, options }) =>
    page.poseGraphProblem(page.makeGraph(graph), { guess: Float64Array.from(guess), ...options }),
};

function solvedBy(problem, { name, kernel, kind, c, x0, options }) {
  const start = x0 === "guess" ? problem.guess : x0;
  return name === "irls"
    ? page.irls(problem, kernel, c, start, options)
    : page.gnc(problem, c, kind, start, options);
}

const SOLVERS = {
  kernels: ({ kernel, c, u }) => {
    const { rho, psi, weight } = page.KERNELS[kernel];
    const each = (f) => u.map((value) => f(value, c));
    return { rho: each(rho), psi: each(psi), weight: each(weight) };
  },
  surrogates: ({ u, c, mu }) => ({
    tls: u.map((value) => page.tlsSurrogate(value, c, mu)),
    tlsWeight: u.map((value) => page.tlsWeight(value, c, mu)),
    gm: u.map((value) => page.gmSurrogate(value, c, mu)),
    gmWeight: u.map((value) => page.gmWeight(value, c, mu)),
  }),
  majorisers: ({ z, sigma, kernel, c, at, x }) => {
    const { value, ...parabola } = page.majoriser(z, sigma, kernel, c, at);
    return { ...parabola, values: x.map(value) };
  },
  leverages: ({ p }) => ({ leverages: page.lineLeverages(p) }),
  loop: ({ problem, method }) => {
    const solved = solvedBy(PROBLEMS[problem.kind](problem), method);
    const history = solved.history.map(({ weights, cost, mu, x }) => ({ weights, cost, mu, x }));
    return { ...solved, history };
  },
  landscapes: ({ z, times, sigma, kernel, c, span, count }) => {
    const cost = page.sampledCost(z, sigma, (u) => page.KERNELS[kernel].rho(u, c), span, count, times);
    return { cost, minima: page.minimaOf(cost) };
  },
  descents: ({ graph, start, weights, method, tol, limit }) =>
    page[method](page.makeGraph(graph), Float64Array.from(start), weights, tol, limit),
  covariances: ({ graph, poses, weights, numbers }) => ({
    all: page.poseCovariances(page.makeGraph(graph), Float64Array.from(poses), weights, numbers),
  }),
  priors: ({ graph, lambda, logOdds }) => {
    const problem = page.poseGraphProblem(page.makeGraph(graph));
    const options = { tol: 1e-9, maxIterations: 300 };
    return page.switchesWithPriors(problem, lambda, logOdds, problem.guess, options);
  },
  fleets: ({ graph, labels, c, options }) =>
    page.solveFleet(page.makeGraph(graph), labels, c, options),
  aliases: ({ truth, ends, size }) => page.agreeingClosures(truth, ends, size),
  attacks: ({ data, state }) => {
    const { bent } = page.attackedMap(data, state);
    return { bent, fooled: bent > 0.5 };
  },
  cliques: ({ adjacency, k }) => sizeOf(page.maxClique(adjacency, k), adjacency, k),
  pcm: ({ graph, gamma }) => {
    const { kept, closures, clique, ...found } = page.pcm(page.makeGraph(graph), gamma);
    const keepsIt = closures.every((edge, place) => Boolean(kept[edge]) === clique.includes(place));
    return { closures, ...found, keepsIt, ...sizeOf(clique, found.adjacency, closures.length) };
  },
  headings: ({ n, edges, turns, R }) => {
    const Q = page.connectionMatrix(n, edges, turns);
    return { Q, ...page.certify(Q, Float64Array.from(R)) };
  },
  rings: ({ angles, alpha }) => ({
    headings: page.relaxedHeadings(angles, alpha).map((angle) => [0, 0, angle]),
  }),
};

// Of several largest cliques the page may have another one than the library.
function sizeOf(clique, adjacency, k) {
  const joined = (v) => clique.every((other) => v === other || adjacency[v * k + other]);
  return { size: clique.length, isClique: clique.every(joined) };
}

function answered(one) {
  try {
    return SOLVERS[given.solver](one);
  } catch (error) {
    return { error: error.message };
  }
}

const plain = (_, value) => (ArrayBuffer.isView(value) ? Array.from(value) : value);
process.stdout.write(JSON.stringify(given.cases.map(answered), plain));
