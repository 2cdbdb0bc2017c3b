/** What a run gave, as elements of the page. */
import { marked } from "./editor.js";
import { element } from "./element.js";

const DRAWN = ".rs-figure";

/**
 * Elements for a result of the engine. A figure takes the place of the stored one, with its
 * number and caption; where code was `changed` it says that these are the chapter's.
 */
export function outputs({ text, shown, error }, stored, changed) {
  const figures = stored.filter((node) => node.nodeName === "FIGURE" && node.querySelector(DRAWN));
  const made = text ? [printed(text)] : [];
  for (const each of shown) {
    const svg = each.data["image/svg+xml"];
    made.push(svg ? drawn(svg, each.metadata, figures.shift(), changed) : rich(each.data));
  }
  if (error) made.push(printed(error, "rs-error"));
  return made;
}

function printed(text, kind = "stream") {
  const pre = element("pre", { tabindex: 0 }, text);
  const box = element("div", { class: "highlight" }, pre);
  return element("div", { class: `output ${kind} highlight-myst-ansi notranslate` }, box);
}

function rich(data) {
  if (data["text/html"]) return html(data["text/html"]);
  if (data["image/png"]) {
    const src = `data:image/png;base64,${data["image/png"]}`;
    return element("img", { src, alt: data["text/plain"] });
  }
  if (data["text/markdown"]) return html(marked.parse(data["text/markdown"]));
  return printed(data["text/plain"]);
}

/** HTML of the reader's own code; its scripts run, as those of the page did. */
function html(text) {
  const box = element("div", { class: "output text_html" });
  box.innerHTML = text;
  for (const still of box.querySelectorAll("script:not([type])")) {
    const script = document.createElement("script");
    script.textContent = still.textContent;
    still.replaceWith(script);
  }
  return box;
}

/** A figure, which is drawn in the page's own font and colours. */
function drawn(svg, metadata, stored, changed) {
  const words = metadata.mystnb ?? {};
  const figure = stored?.cloneNode(true) ?? element("figure", { class: "align-default" });
  const made = element("div", { class: "rs-figure" });
  made.innerHTML = svg;
  const drawing = made.querySelector(DRAWN) ?? made; // other objects give SVG alone
  const before = figure.querySelector(DRAWN);
  const own = words.image?.alt ?? "A figure that the code of this cell draws.";
  drawing.setAttribute("role", "img");
  drawing.setAttribute("aria-label", changed || !before ? own : before.getAttribute("aria-label"));
  if (before) before.replaceWith(drawing);
  else figure.append(drawing);
  const caption = figure.querySelector(".caption-text");
  if (!caption || !changed) return figure;
  if (words.figure?.caption) caption.innerHTML = marked.parseInline(words.figure.caption);
  else caption.prepend("Drawn by your code. The chapter’s caption: ");
  return figure;
}
