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

const LARGEST = { "is-picture": 1.6, "is-figure": 2.4, "is-formula": 2.8, "is-table": 2.2 };

const WIDTHS = [780, 980, 1180]; // pixels of words in a box: the one in which they are largest

function fit(show) {
  const shown = show.firstElementChild;
  if (!shown.offsetWidth) return;
  const section = show.closest("section");
  const largest = LARGEST[[...section.classList].find((name) => LARGEST[name])];
  const scaleAt = (width) => {
    shown.style.width = width && `${width}px`;
    return Math.min(
      show.clientWidth / shown.offsetWidth, show.clientHeight / shown.offsetHeight, largest ?? 1.7,
    );
  };
  const widths = section.matches(".is-box, .is-list") ? WIDTHS : [""];
  const best = widths.reduce((one, other) => (scaleAt(other) > scaleAt(one) ? other : one));
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
