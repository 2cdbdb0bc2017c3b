// Begins the deck, and draws what a slide shows as large as its place allows.
// A global name, for tests and for the console.
var deck = new Reveal({
  width: 1280,
  height: 720,
  margin: 0,
  center: false,
  hash: true,
  transition: "none",
  slideNumber: "c/t",
  plugins: [RevealNotes],
  // Keys that a picture or a question uses do not turn the page.
  keyboardCondition: (event) => !event.defaultPrevented
    && !event.target.closest(".rs-picture, form"),
});

// A presenter's Page keys always do, also with a handle or an answer in focus, which has them.
addEventListener("keydown", (event) => {
  const turn = { PageDown: "next", PageUp: "prev" }[event.key];
  if (!turn) return;
  event.preventDefault();
  event.stopPropagation();
  document.activeElement.blur();
  deck[turn]();
}, true);

// Once the pointer lets go, or a vote is given, the keys are the deck's again, and the next brings
// the claim and the picture's answer; what the Tab key reached keeps its own.
const free = () => document.activeElement.blur();
addEventListener("pointerup", () => setTimeout(() => {
  if (!document.activeElement.matches("select")) free(); // its list is still open
}));
addEventListener("change", ({ target }) => target.closest("form") && free());

// A claim that a key brings shows the answer in its picture, and takes it back as it goes.
const press = (key, button) => deck.on(key, ({ fragment }) => {
  if (fragment.matches("h1, h2")) fragment.closest("section").querySelector(button)?.click();
});
press("fragmentshown", "[data-show]");
press("fragmenthidden", "[data-control=reset]");
for (const hand of ["pointerdown", "keydown", "input"]) {
  addEventListener(hand, ({ target }) => {
    target.closest(".rs-stage, .rs-controls")?.closest("section").classList.add("is-held");
  }, true);
}

const LARGEST = { "is-picture": 1.6, "is-figure": 2.4, "is-formula": 4.5, "is-table": 2.2 };

const POINT = 4 / 3; // pixels
const WIDTHS = { "is-list": [780, 980, 1180], "is-table": ["", 1216, 1500] }; // pixels: the one in which words are largest

const LETTER = 0.042; // of a drawing's height, for the last row

// Cuts a drawing's margins off, down to its letters and its axes, by which the rest is clipped.
function cut(svg) {
  const { width: whole, height } = svg.viewBox.baseVal;
  for (const text of svg.querySelectorAll("text, tspan[style]")) {
    const size = parseFloat(getComputedStyle(text).fontSize);
    text.style.fontSize = `${Math.max(size, Math.min(1.2 * size, LETTER * height))}px`;
  }
  Object.assign(svg.style, { width: `${whole * POINT}px`, maxWidth: "none" });
  const { left, top, width } = svg.getBoundingClientRect();
  const scale = whole / width;
  const boxes = [...svg.querySelectorAll("g > g ~ g :is(text, path, use)")].filter((part) => !part.closest("defs")).map((part) => {
    const clip = part.closest("[clip-path]")?.getAttribute("clip-path").slice(4, -1);
    if (clip) return svg.querySelector(`${clip} rect`).getBBox();
    const box = part.getBoundingClientRect();
    return new DOMRect(scale * (box.x - left), scale * (box.y - top), scale * box.width, scale * box.height);
  });
  const [x, y] = ["x", "y"].map((side) => Math.min(...boxes.map((box) => box[side])));
  const across = Math.max(...boxes.map((box) => box.x + box.width)) - x;
  const down = Math.max(...boxes.map((box) => box.y + box.height)) - y;
  svg.setAttribute("viewBox", `${x} ${y} ${across} ${down}`);
  Object.assign(svg.style, { width: `${across * POINT}px`, height: `${down * POINT}px` });
  svg.dataset.cut = "";
  if (across > 1.5 * down && !svg.previousElementSibling) svg.parentElement.style.flexDirection = "column";
}

function fit(show) {
  const shown = show.firstElementChild;
  if (!shown.offsetWidth) return;
  for (const svg of shown.querySelectorAll("figure svg.rs-wide:not([data-cut])")) cut(svg);
  const section = show.closest("section");
  const kind = [...section.classList].find((name) => name.startsWith("is-"));
  const scaleAt = (width) => {
    shown.style.width = width && `${width}px`;
    return Math.min(
      show.clientWidth / shown.offsetWidth, show.clientHeight / shown.offsetHeight, LARGEST[kind] ?? 1.7,
    );
  };
  const best = (WIDTHS[kind] ?? [""]).reduce((one, other) => (scaleAt(other) > scaleAt(one) ? other : one));
  shown.style.transform = `scale(${scaleAt(best)})`;
}

// A picture is drawn when its slide comes, and only then has its size.
const sized = new ResizeObserver((seen) => {
  for (const { target } of seen) fit(target.closest(".show"));
});
for (const show of document.querySelectorAll(".show")) {
  sized.observe(show);
  sized.observe(show.firstElementChild);
}
deck.initialize();
