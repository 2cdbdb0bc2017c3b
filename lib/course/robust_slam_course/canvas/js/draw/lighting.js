import { htmlElement } from "./controls.js";
import { KEYS_STAY } from "./scene.js";

/** What names a part of a picture, and the part: a word of the text, or a formula of one letter. */
const NAMED = {
  "wrong closure": ".is-outlier, .rs-wrong *",
  outlier: ".is-outlier, .rs-wrong *",
  "correct closure": ".is-inlier, .rs-right *",
  inlier: ".is-inlier, .rs-right *",
  "true path": ".is-ghost",
  majoriser: ".is-accent",
  eigenvalue: ".rs-eigen",
  c: '[data-control="c"]',
  σ: '[data-control="sigma"]',
  μ: '[data-control="step"]',
  α: '[data-control="alpha"]',
};
const WORDS = new RegExp(`\\b((?:${Object.keys(NAMED).filter((name) => name[1]).join("|")})s?)\\b`, "i");

/** Light the parts that `selector` finds while the others fade; without one, end it. */
function light(el, selector) {
  // A style sheet of the page: what is drawn stays as it is, and may be drawn again meanwhile.
  const sheet = document.getElementById("rs-light")
    ?? document.head.appendChild(htmlElement("style", { id: "rs-light" }));
  document.querySelector("[data-lighting]")?.removeAttribute("data-lighting");
  sheet.textContent = "";
  if (!selector) return;
  el.dataset.lighting = "";
  sheet.textContent = el.querySelector(".rs-stage").querySelector(selector)
    ? `[data-lighting] .rs-stage :is(path, line, circle, text):not(${selector}) { opacity: 0.2; }`
    : `[data-lighting] :is(${selector}) { outline: 3px solid var(--rs-accent); outline-offset: 3px; }`;
}

/** Light a part under the pointer with what shows the same, as an edge and its bar. */
export function lightTwins(el, stage) {
  stage.addEventListener("mouseover", ({ target }) => {
    const twins = `[data-part="${target.dataset.part}"]`;
    light(el, stage.querySelectorAll(twins).length > 1 ? twins : null);
  });
  stage.addEventListener("mouseleave", () => light(el, null));
}

/** Let the paragraph above the picture's cell and the one below name its parts. */
export function linkText(el) {
  if (document.readyState === "loading") {
    // The paragraphs below are still to come.
    document.addEventListener("DOMContentLoaded", () => linkText(el), { once: true });
    return;
  }
  const cell = el.closest(".cell");
  for (const beside of [cell?.previousElementSibling, cell?.nextElementSibling]) {
    if (beside?.matches("p")) linkWords(el, beside);
  }
}

/** Make words in `root` that name visible parts of the picture buttons that light them, each once. */
export function linkWords(el, root) {
  const named = new Set();
  const link = (shown) => {
    const name = shown.textContent.toLowerCase().replace(/s$/, "");
    const [part] = [...el.querySelectorAll(NAMED[name] ?? "none")].filter((each) => !each.closest("details:not([open])"));
    if (!part || named.has(name)) return;
    named.add(name);
    const [look = ""] = NAMED[name].match(/is-\w+/) ?? [];
    const word = htmlElement("button", { type: "button", class: `rs-word ${look}`, ...KEYS_STAY });
    // A formula alone is no name.
    if (shown instanceof Element) word.ariaLabel = shown.textContent;
    for (const kind of ["mouseenter", "focus"]) word.addEventListener(kind, () => light(el, NAMED[name]));
    for (const kind of ["mouseleave", "blur"]) word.addEventListener(kind, () => light(el, null));
    shown.replaceWith(word);
    word.append(shown);
  };
  root.normalize();
  for (const text of textsOf(root)) {
    for (let rest = text, found; (found = WORDS.exec(rest.data));) {
      const shown = rest.splitText(found.index);
      rest = shown.splitText(found[0].length);
      link(shown);
    }
  }
  root.querySelectorAll("math").forEach(link);
}

function textsOf(root) {
  const [walker, texts] = [document.createTreeWalker(root, NodeFilter.SHOW_TEXT), []];
  while (walker.nextNode()) {
    if (!walker.currentNode.parentElement.closest("a, code, math, button")) texts.push(walker.currentNode);
  }
  return texts;
}
