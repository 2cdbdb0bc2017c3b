import { LAST_STEP, htmlElement, makeControl, valuesWithin } from "./controls.js";
import { Glide } from "./glide.js";
import { lightTwins, linkText, linkWords } from "./lighting.js";
import { stateFromHash, stateToHash } from "./link.js";
import { KEYS_STAY, Scene, setAttributes } from "./scene.js";
import { stageHeight } from "./stage.js";

export const REST = 700; // ms without a change after which the caption is spoken
const NEAR = 0.004; // what is left of a movement, in the picture's units, when it has arrived

/**
 * Run a live picture inside `el`. `model` follows anywidget's convention: `get("name")`,
 * `get("texts")` {title, question, tries}, `get("state")`, `get("data")` and `get("answer")`, what
 * differs from the first state where the answer to the question is seen; `set` and `save_changes`
 * hand the state back to Python. `spec` says what is particular:
 * - `controls`: see `makeControl`
 * - `main`: names (or labels, of buttons) of the controls that stand below the drawing; the one that
 *   is left is folded away, unless a link brings it in another state
 * - `seen(state, result, answer)`: the reader's hand has found the answer; where absent, once the state
 *   has come as far from the first as the answer is
 * - `joins`: an answer to the question brings the picture at once where it is seen
 * - `clean(state, data)`: the nearest state that is possible, of what no control bounds; a link may
 *   hold any (may be absent)
 * - `solve(state, data)`: all that follows from a state
 * - `moving(result)`: the numbers that glide from one result to the next (may be absent)
 * - `height(width)`: of the drawing, in pixels (`stageHeight` where absent)
 * - `layers`: names from back to front; "handles" holds what can be taken hold of
 * - `draw(scene, view)`: one pass; `view` has state, result, shown (the gliding numbers),
 *   width, height, data, and change(partial)
 * - `caption(view)`: what is seen, in one to three sentences
 */
export function livePicture({ model, el }, spec) {
  const [name, texts, data, answer] = ["name", "texts", "data", "answer"].map((key) => model.get(key));
  const given = model.get("state");
  const clean = (any) => {
    const bounded = { ...any, ...valuesWithin(spec.controls, any, given) };
    return spec.clean ? spec.clean(bounded, data) : bounded;
  };
  const first = clean(given);
  const calm = window.matchMedia("(prefers-reduced-motion: reduce)");
  const linked = () => stateFromHash(name, window.location.hash, first);
  let state = clean(linked() ?? first);
  let result = spec.solve(state, data);
  let [asked, stale, spoken, rested, judged, found] = [0, false, 0, null, 0, false];
  const glide = new Glide();
  const parts = frame(el, texts, spec, choose, calm);
  const scene = new Scene(parts.stage, texts.title);
  scene.root.addEventListener("pointerleave", () => {
    scene.held = false;
    ask();
  });
  const view = { data, change, picture: el };
  const question = el.querySelector(".rs-predict");

  function change(partial) {
    state = clean({ ...state, ...partial });
    stale = true;
    ask();
  }

  /** Change what a control, and no hand in the drawing does: its maps are fitted anew. */
  function choose(partial) {
    scene.held = false;
    change(partial);
  }

  function ask() {
    if (!asked) asked = requestAnimationFrame(show);
  }

  function show(time) {
    asked = 0;
    const began = performance.now();
    if (stale) {
      result = spec.solve(state, data);
      stale = false;
      handBack();
      // Who has predicted finds out by hand, and rests, before the verdict is given.
      clearTimeout(judged);
      judged = setTimeout(() => { if (found) delete question.dataset.waits; ask(); }, REST);
    }
    const target = spec.moving ? spec.moving(result) : [];
    glide.aim(target, calm.matches);
    if (glide.advance(time) > NEAR) ask();
    else glide.arrive();
    draw();
    performance.measure("rs-picture", { start: began, end: performance.now() });
  }

  function draw() {
    const width = Math.max(280, parts.stage.clientWidth);
    const height = (spec.height ?? stageHeight)(width);
    Object.assign(view, { state, result, shown: glide.shown, width, height });
    scene.begin(view.width, view.height, [...spec.layers, "handles"]);
    spec.draw(scene, view);
    scene.end();
    for (const control of parts.controls) control.show(state, result);
    found ||= isSeen();
    tell(spec.caption(view));
  }

  function tell(text) {
    if (parts.caption.textContent === text) return;
    rested ??= text;
    parts.caption.replaceChildren(...wordsOf(text, rested));
    linkWords(el, parts.caption);
    // A screen reader hears the caption once the hand rests, not at every pixel.
    clearTimeout(spoken);
    spoken = setTimeout(() => { rested = parts.spoken.textContent = text; }, REST);
  }

  function handBack() {
    model.set("state", state);
    model.save_changes();
  }

  // What the answer leaves to time is played.
  const players = parts.controls.filter(({ play, name: own }) => play && spec.main.includes(own) && !(own in answer));
  const shows = () => {
    choose({ ...first, ...answer });
    for (const { play } of players) play();
  };
  const isSeen = () => players.every(({ hasEnded }) => hasEnded())
    && (spec.seen ? spec.seen(state, result, answer) : hasReached(state, first, answer));
  const halt = () => parts.controls.forEach(({ stop }) => stop?.());
  parts.reset.addEventListener("click", () => {
    question.reset();
    halt();
    choose(first);
  });
  el.addEventListener("keydown", ({ key }) => key === "Escape" && halt());
  offerToShow(el, shows);
  question.addEventListener("change", () => {
    clearTimeout(judged);
    found = isSeen();
    question.toggleAttribute("data-waits", !found);
    if (spec.joins) choose(answer);
    else ask();
  });
  parts.link.addEventListener("click", async () => {
    window.history.replaceState(null, "", stateToHash(name, state, first));
    nameIcon(parts.link, "The address has this state now");
    setTimeout(() => nameIcon(parts.link, LINK), 2500);
    await navigator.clipboard?.writeText(window.location.href).catch(() => {});
  });
  const played = Object.fromEntries(players.map((each) => [each.name, LAST_STEP]));
  const printing = () => putOnPaper(parts, spec, view, [first, { ...first, ...played, ...answer }], clean);
  window.addEventListener("beforeprint", printing);
  const unfold = () => {
    const shown = linked();
    const other = (each) => JSON.stringify(shown[each]) !== JSON.stringify(first[each]);
    if (shown && parts.folded.some(other)) parts.more.open = true;
  };
  const follow = () => {
    if (!linked()) return;
    unfold();
    choose(linked());
  };
  window.addEventListener("hashchange", follow);
  const resized = new ResizeObserver(ask);
  resized.observe(parts.stage);
  model.on?.("change:state", () => {
    const wanted = model.get("state");
    if (JSON.stringify(wanted) !== JSON.stringify(state)) change(wanted);
  });
  unfold();
  glide.aim(spec.moving ? spec.moving(result) : [], true);
  draw();
  parts.spoken.textContent = "";
  clearTimeout(spoken);
  if (linked()) el.scrollIntoView({ block: "center" });
  for (const control of el.querySelectorAll("[data-control]")) setAttributes(control, KEYS_STAY);
  lightTwins(el, parts.stage);
  linkText(el);
  el.dataset.live = "";
  return () => {
    window.removeEventListener("hashchange", follow);
    window.removeEventListener("beforeprint", printing);
    resized.disconnect();
    cancelAnimationFrame(asked);
    clearTimeout(spoken);
  };
}

const [RESET, LINK] = ["Back to the first state", "Copy a link to this state"];
const [PAPER, SHARES] = [290, [0, 0.5, 1]]; // pixels, as on a small phone; from the first state to the answer

/** Name a button that is an icon, to eyes and ears. */
function nameIcon(button, name) {
  setAttributes(button, { "aria-label": name, title: name });
}

/** An icon that is pressed, of the path `d` in a square of 16. */
function iconButton(control, name, d) {
  const button = htmlElement("button", { type: "button", "data-control": control });
  button.innerHTML = `<svg viewBox="0 0 16 16" aria-hidden="true"><path d="${d}"/></svg>`;
  nameIcon(button, name);
  return button;
}

/** Before it is printed a picture is drawn three times, between the states `ends`; afterwards these go. */
function putOnPaper(parts, spec, view, ends, clean) {
  const states = SHARES.map((share) => clean(between(...ends, share)));
  const seen = states.filter((state, k) => k < 1 || JSON.stringify(state) !== JSON.stringify(states[k - 1]));
  const row = htmlElement("div", { class: "rs-paper" });
  parts.stage.after(row);
  seen.forEach((state, k) => {
    const [figure, result] = [htmlElement("figure"), spec.solve(state, view.data)];
    row.append(figure);
    const scene = new Scene(figure, `${view.picture.ariaLabel} ${k}`);
    const shown = Float64Array.from(spec.moving ? spec.moving(result) : []);
    const drawn = { ...view, state, result, shown, width: PAPER, height: (spec.height ?? stageHeight)(PAPER) };
    scene.begin(PAPER, drawn.height, [...spec.layers, "handles"]);
    spec.draw(scene, drawn);
    scene.end();
    figure.append(htmlElement("figcaption", {}, spec.caption(drawn)));
  });
  window.addEventListener("afterprint", () => row.remove(), { once: true });
}

/** Whether each part of a state has come from `first` to its part in `answer`, or beyond. */
function hasReached(state, first, answer) {
  return Object.entries(answer).every(([key, to]) => {
    const [now, from] = [state[key], first[key]];
    if (key === "tried" || from === to) return true;
    if (Array.isArray(to)) return hasReached(now, from, to);
    return typeof to === "number" ? (now - from) / (to - from) > 0.93 : now === to;
  });
}

/** From `one` value to the `other`, a share of the way: numbers, and lists and states of them. */
function between(one, other, share) {
  if (share === 1) return other;
  if (typeof one === "number" && typeof other === "number") return one + share * (other - one);
  if (!one || !other || typeof one !== "object") return one;
  const way = Object.keys(one).map((key) => [key, between(one[key], other[key], share)]);
  return Array.isArray(one) ? way.map(([, value]) => value) : Object.fromEntries(way);
}

/** The words of a readout; figures that the text before had not are strong. */
function wordsOf(text, before) {
  const bare = (word) => word.replace(/[.,:;)]+$/, "");
  const known = new Set(before.split(/\s+/).map(bare));
  return text.split(/(\s+)/).flatMap((word) => (/\d/.test(word)
    ? [htmlElement(known.has(bare(word)) ? "span" : "strong", {}, bare(word)), word.slice(bare(word).length)] : [word]
  ));
}

/** The picture's frame: question, stage, main controls, readout; one more question is folded. */
function frame(el, texts, spec, change, calm) {
  const controls = spec.controls.map((control) => makeControl(control, change, calm));
  const row = (wanted) => htmlElement("div", { class: "rs-controls" }, ...controls
    .filter((_, k) => wanted(spec.controls[k])).map(({ element }) => element));
  const isMain = ({ name, label }) => spec.main.includes(name ?? label);
  const tries = texts.tries.map((text) => htmlElement("p", { class: "rs-ask" }, text));
  const parts = {
    controls,
    stage: htmlElement("div", { class: "rs-stage" }),
    caption: htmlElement("p", { class: "rs-caption" }),
    spoken: htmlElement("p", { class: "rs-spoken", "aria-live": "polite" }),
    reset: iconButton("reset", RESET, "M3 3v4h4M3.2 7a5 5 0 1 1-.2 3"),
    link: iconButton("link", LINK, "M7 9 9.5 6.5M6 6 4 8a2.8 2.8 0 0 0 4 4l2-2M10 10l2-2a2.8 2.8 0 0 0-4-4L6 6"),
    folded: spec.controls.filter((each) => each.name && !isMain(each)).map(({ name }) => name),
  };
  parts.more = htmlElement(
    "details", { class: "rs-folded" }, htmlElement("summary", KEYS_STAY, "More to try"),
    ...tries, row((each) => !isMain(each)),
  );
  el.classList.add("rs-picture");
  el.setAttribute("role", "group");
  el.setAttribute("aria-label", texts.title);
  el.replaceChildren(
    predictionOf(el, texts.question), parts.stage, row(isMain), parts.caption, parts.spoken,
    htmlElement("div", { class: "rs-icons" }, parts.link, parts.reset), parts.more,
  );
  return parts;
}

/** The question of a picture: on a page the one that stands there, else one made of `html`. */
function predictionOf(el, html) {
  const template = document.createElement("template");
  template.innerHTML = html ?? "";
  return el.querySelector(".rs-predict") ?? template.content.firstElementChild;
}

/** Put a button behind each answer that calls `show`, which brings the picture where it is seen. */
function offerToShow(el, show) {
  for (const said of el.querySelectorAll(".rs-predict p")) {
    const button = htmlElement("button", { type: "button", "data-show": true, ...KEYS_STAY }, "Show it");
    button.addEventListener("click", show);
    said.append(" ", button);
  }
}
