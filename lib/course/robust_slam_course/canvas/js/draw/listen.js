import { numberText } from "./number.js";
import { htmlElement, makeControl } from "./controls.js";
import { putEdge } from "./map.js";
import { REST, livePicture } from "./picture.js";
import { KEYS_STAY, setAttributes } from "./scene.js";
import { graphResidualNorms } from "../solve/pose_graph.js";

/**
 * A live picture whose pose graph can be heard, too, edge by edge; `spec` is that of `livePicture`.
 * A result of `solve` has `heard`: { graph, poses (3n), weights (m, by default 1), map }, where `map` is
 * the key of the map in `scene.fits`.
 *
 * Own code, because chart2music plays values over an axis and has no edges with two ends, weights and
 * values that change under the hand, and its 56 kB (gzipped) are twice a whole picture.
 */
export function audiblePicture(context, spec) {
  let [pass, ear] = [null, null];
  const draw = (scene, view) => {
    spec.draw(scene, view);
    pass = { scene, heard: view.result.heard, change: view.change };
    ear?.follow(pass);
  };
  const end = livePicture(context, { ...spec, draw });
  if (!window.AudioContext) return end;
  const button = htmlElement("button", {
    type: "button", class: "rs-listen", "aria-expanded": "false", ...KEYS_STAY,
  }, "Listen to the edges");
  button.addEventListener("click", () => {
    ear = ear ? ear.close() : openEar(button, pass, spec.layers[0]);
    setAttributes(button, { "aria-expanded": String(ear !== null) });
  });
  context.el.querySelector(".rs-folded").before(button);
  return () => { ear?.close(); end(); };
}

const HOW = "Four times the residual is an octave higher, and a smaller weight is softer. Arrow keys go along the"
  + " odometry and then over the closures; the space bar plays on, and stops.";
const EACH = 160; // ms from one tone to the next while playing

/** Put a slider over the edges after `button`; `layer` is where the one that is heard is marked. */
function openEar(button, first, layer) {
  const audio = new AudioContext();
  let [pass, walk, at, played, timer] = [first, walkOf(first.heard), 0, null, 0];
  const player = makeControl({
    kind: "player", name: "edge", label: "Edge", beat: EACH, count: () => walk.length - 1, text: (k) => walk[k].text,
  }, ({ edge }) => { at = edge; tell(); play(); }, { matches: false });
  const spoken = htmlElement("p", { class: "rs-spoken", "aria-live": "polite" });
  const row = htmlElement(
    "div", { class: "rs-controls rs-hearing" }, htmlElement("p", { class: "rs-ask" }, HOW), player.element, spoken,
  );
  const [slider, toggle] = row.querySelectorAll("input, button");
  for (const each of [slider, toggle]) setAttributes(each, KEYS_STAY);
  slider.addEventListener("keydown", (event) => {
    if (event.key !== " ") return;
    event.preventDefault();
    toggle.click();
  });
  const play = () => { played = walk[at]; playEdge(audio, played); };
  const mark = () => {
    const { map, poses } = pass.heard;
    putEdge(pass.scene, layer, "heard", pass.scene.fits.get(map), poses, walk[at].ends, "rs-heard", 11);
  };
  const rest = () => {
    if (walk[at] !== played) play();
    // While it has the focus, the slider speaks for itself.
    if (document.activeElement !== slider) spoken.textContent = walk[at].text;
  };
  const tell = () => {
    player.show({ edge: at });
    mark();
    clearTimeout(timer);
    timer = setTimeout(rest, REST);
  };
  const follow = (next) => {
    const same = next.heard === pass.heard;
    pass = next;
    if (same) return mark();
    walk = walkOf(pass.heard);
    at = Math.min(at, walk.length - 1);
    return tell();
  };
  const close = () => {
    clearTimeout(timer);
    audio.close();
    row.remove();
    pass.change({}); // which draws the map without the mark
    return null;
  };
  button.after(row);
  tell();
  return { follow, close };
}

/** The edges in the order in which they are heard: the odometry, then the closures by their earlier pose. */
function walkOf({ graph, poses, weights }) {
  const norms = graphResidualNorms(graph, poses);
  const earlier = (k) => Math.min(graph.tail[k], graph.head[k]);
  return ["odometry", "closure"].flatMap((kind, isClosure) => {
    const own = [...graph.tail.keys()].filter((k) => Boolean(graph.isOdometry[k]) !== Boolean(isClosure));
    return own.sort((one, other) => earlier(one) - earlier(other)).map((k, place) => {
      const [ends, weight] = [[graph.tail[k], graph.head[k]], weights?.[k] ?? 1];
      const text = `${kind} ${place + 1} of ${own.length}, from pose ${ends[0]} to pose ${ends[1]},`
        + ` residual ${norms[k].toFixed(1)}\u00a0σ, weight ${numberText(weight, 2)}`;
      return { ends, isClosure, norm: norms[k], weight, text };
    });
  });
}

const [AT_ONE, LOWEST, HIGHEST] = [220, 110, 3520]; // Hz; at one σ, and what small loudspeakers can play
const [LOUD, SOFT, LASTS] = [0.3, 0.06, 0.2]; // the gains of the weights 1 and 0, and s

/** Play the tone of an edge, a purer one for odometry than for a closure. */
function playEdge(audio, { isClosure, norm, weight }) {
  const [source, volume, now] = [audio.createOscillator(), audio.createGain(), audio.currentTime];
  source.type = isClosure ? "triangle" : "sine";
  source.frequency.value = Math.min(HIGHEST, Math.max(LOWEST, AT_ONE * Math.sqrt(norm)));
  // A tone that begins or ends at once would click.
  volume.gain.setValueAtTime(0, now);
  volume.gain.linearRampToValueAtTime(SOFT + weight * (LOUD - SOFT), now + 0.01);
  volume.gain.linearRampToValueAtTime(0, now + LASTS);
  source.connect(volume).connect(audio.destination);
  source.start(now);
  source.stop(now + LASTS);
}
