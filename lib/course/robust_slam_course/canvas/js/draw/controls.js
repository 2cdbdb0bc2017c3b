import { boundedNumber } from "./link.js";

/** A new HTML element with attributes and children (elements or texts). */
export function htmlElement(name, attributes = {}, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value !== null && value !== false) element.setAttribute(key, value === true ? "" : value);
  }
  element.append(...children);
  return element;
}

/**
 * The native control of a specification. `change(partial)` is called with what the
 * reader chose. Returns `{element, show(state, result)}`, which brings the control up to date.
 *
 * Kinds: `slider` (name, label, min, max, step, text(value), log), `choice` (name, label,
 * options [[value, text], …]), `words` (as `choice`, all in sight), `toggle` (name, label), `button`
 * (label, does(state, result) →
 * partial) and `player` (name, label, count(state, result), text(value, result), beat), a slider over
 * steps that can play, one in so many ms.
 */
export function makeControl(spec, change, calm) {
  return { slider, choice, words, toggle, button, player }[spec.kind](spec, change, calm);
}

/** A step that stands for the last one, however many there are. */
export const LAST_STEP = 1e6;

/** The nearest values that the controls `[spec, …]` can give; where there is none, that of `first`. */
export function valuesWithin(specs, state, first) {
  const within = ({ kind, name, min, max, step, log, options }) => {
    const [value, instead] = [state[name], first[name]];
    if (options) return options.some(([one]) => one === value) ? value : instead;
    if (kind === "toggle") return Boolean(value);
    if (kind === "player") return boundedNumber(value, [0, LAST_STEP], instead, 0);
    const steps = log ? value : Number((min + step * Math.round((value - min) / step)).toPrecision(12));
    return boundedNumber(steps, [min, max], instead);
  };
  const named = specs.filter(({ name }) => name);
  return Object.fromEntries(named.map((spec) => [spec.name, within(spec)]));
}

function slider(spec, change) {
  const forward = spec.log ? Math.log10 : (value) => value;
  const back = spec.log ? (position) => Number((10 ** position).toPrecision(4)) : (position) => position;
  const input = htmlElement("input", {
    type: "range", min: forward(spec.min), max: forward(spec.max), step: spec.step,
    "data-control": spec.name, autocomplete: "off",
  });
  const value = htmlElement("span", { class: "rs-value", "aria-hidden": "true" });
  input.addEventListener("input", () => change({ [spec.name]: back(Number(input.value)) }));
  const show = (state) => {
    input.value = forward(state[spec.name]);
    value.textContent = spec.text(state[spec.name]);
    input.setAttribute("aria-valuetext", value.textContent);
  };
  return { element: htmlElement("label", {}, htmlElement("span", {}, spec.label), input, value), show };
}

function choice(spec, change) {
  const options = spec.options.map(([value, text]) => htmlElement("option", { value }, text));
  const select = htmlElement("select", { "data-control": spec.name, autocomplete: "off" }, ...options);
  select.addEventListener("input", () => change({ [spec.name]: select.value }));
  const show = (state) => { select.value = state[spec.name]; };
  return { element: htmlElement("label", {}, htmlElement("span", {}, spec.label), select), show };
}

function words(spec, change) {
  const options = spec.options.map(([value, text]) => (
    htmlElement("button", { value, type: "button", "data-control": text }, text)));
  const element = htmlElement("span", { class: "rs-player", role: "group", "aria-label": spec.label }, ...options);
  element.addEventListener("click", ({ target }) => target.value && change({ [spec.name]: target.value }));
  const show = (state) => options.forEach((option) => (
    option.setAttribute("aria-pressed", String(option.value === state[spec.name]))));
  return { element, show };
}

function toggle(spec, change) {
  const box = htmlElement("input", { type: "checkbox", "data-control": spec.name, autocomplete: "off" });
  box.addEventListener("input", () => change({ [spec.name]: box.checked }));
  const show = (state) => { box.checked = state[spec.name]; };
  return { element: htmlElement("label", {}, box, htmlElement("span", {}, spec.label)), show };
}

function button(spec, change) {
  const element = htmlElement("button", { type: "button", "data-control": spec.label }, spec.label);
  let latest = [];
  // `disabled` would take the focus away from a reader who pressed the button by keyboard.
  element.addEventListener("click", () => {
    if (element.getAttribute("aria-disabled") !== "true") change(spec.does(...latest));
  });
  const show = (...now) => {
    latest = now;
    element.setAttribute("aria-disabled", String(spec.when ? !spec.when(...now) : false));
  };
  return { element, show };
}

const BEAT = 450; // ms

function player(spec, change, calm) {
  const input = htmlElement("input", { type: "range", min: 0, step: 1, "data-control": spec.name });
  const play = htmlElement("button", { type: "button", "data-control": `play-${spec.name}` }, calm.matches ? "Step" : "Play");
  const value = htmlElement("span", { class: "rs-value", "aria-hidden": "true" });
  let timer = 0;
  // While it plays, a screen reader that stands on the slider shall not read every step.
  const say = () => input.setAttribute("aria-valuetext", value.textContent);
  const stop = () => {
    clearInterval(timer);
    timer = 0;
    play.textContent = calm.matches ? "Step" : "Play";
    say();
  };
  const hasEnded = () => Number(input.value) >= Number(input.max);
  const forward = () => {
    if (!input.isConnected || hasEnded()) return stop();
    return change({ [spec.name]: Number(input.value) + 1 });
  };
  input.addEventListener("input", () => { stop(); change({ [spec.name]: Number(input.value) }); });
  play.addEventListener("click", () => {
    if (timer) return stop();
    const ended = hasEnded();
    // Readers who asked for less movement go step by step.
    if (calm.matches) return change({ [spec.name]: ended ? 0 : Number(input.value) + 1 });
    return run(ended ? 0 : Number(input.value));
  });
  const run = (from) => {
    stop();
    change({ [spec.name]: from });
    play.textContent = "Pause";
    timer = setInterval(forward, spec.beat ?? BEAT);
  };
  /** From the first step to the last; at once for readers who asked for less movement. */
  const runAll = () => (calm.matches ? change({ [spec.name]: LAST_STEP }) : run(0));
  const show = (state, result) => {
    input.max = spec.count(state, result);
    input.value = state[spec.name];
    value.textContent = spec.text(state[spec.name], result);
    if (!timer) say();
  };
  const label = htmlElement("label", {}, htmlElement("span", {}, spec.label), input, value);
  return { element: htmlElement("span", { class: "rs-player" }, label, play), show, name: spec.name, play: runAll, stop, hasEnded };
}
