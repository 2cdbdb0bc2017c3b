// The code of a chapter is in sight once its link was followed, or one to a cell.
const showCode = () => {
  if (/^#code\b/.test(location.hash)) document.documentElement.dataset.code = "";
};
addEventListener("hashchange", showCode);
showCode();
// Arrow keys look at the answers of a quiz, and the space bar gives one.
addEventListener("keydown", (event) => {
  const step = { ArrowDown: 1, ArrowRight: 1, ArrowUp: -1, ArrowLeft: -1 }[event.key];
  if (!step || !event.target.matches(".rs-quiz input")) return;
  event.preventDefault();
  const all = [...event.target.form.elements].filter((each) => each.type === "radio");
  all.at((all.indexOf(event.target) + step) % all.length).focus();
});
// What has copied keeps the focus, which the selection that it copied from has taken.
addEventListener("click", ({ target }) => {
  if (target.closest("#pst-secondary-sidebar-modal a")) target.closest("dialog").close();
  const button = target.closest(".copybtn");
  setTimeout(() => button?.focus());
});
addEventListener("load", () => {
  // The Tab key goes on from the place to which a link led.
  const target = document.querySelector(":target");
  if (target) Object.assign(target, { tabIndex: -1 }).focus({ preventScroll: true });

  // Letters of an icon font are not read out.
  for (const icon of document.querySelectorAll("i[class*=fa-]")) icon.ariaHidden = "true";

  // The theme scrolls the list of pages so far that its head is gone, when the page is parsed. The
  // page that is read shall be seen, and no more.
  document.querySelector(".bd-links .current > a")?.scrollIntoView({ block: "nearest" });

  // The section that is read stays in view in a list of sections that is longer than the window.
  const column = document.querySelector(".bd-sidebar-secondary");
  if (!column) return;
  const follow = () => {
    const link = [...column.querySelectorAll("a.active")].at(-1);
    if (!link) return;
    const [inside, around] = [link, column].map((element) => element.getBoundingClientRect());
    const isSeen = inside.top > around.top && inside.bottom < around.bottom;
    if (!isSeen) column.scrollTop += inside.top - around.top - around.height / 2;
  };
  new MutationObserver(follow).observe(column, { subtree: true, attributeFilter: ["class"] });
});
