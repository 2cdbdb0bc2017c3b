async (picture, withHandles) => {
  // Drive a live picture to its extremes, and return what is wrong with its layout there.
  const frame = () => new Promise((done) => requestAnimationFrame(done));
  const settled = async () => { await frame(); await frame(); };
  const all = (query) => [...picture.querySelectorAll(query)];
  const faults = new Map();
  const tell = (text, where) => { if (!faults.has(text)) faults.set(text, where); };

  const inset = ({ left, right, top, bottom }, x, y) => (
    { left: left + x, right: right - x, top: top + y, bottom: bottom - y });
  const meet = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1
    && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1;
  const outside = (a, b, slack) => a.left < b.left - slack || a.right > b.right + slack
    || a.top < b.top - slack || a.bottom > b.bottom + slack;

  function look(where) {
    const root = picture.querySelector(".rs-stage > svg");
    const stage = root.getBoundingClientRect();
    // The box of a text is that of its font, which is taller than its letters.
    const texts = all("svg text").map((text) => ({
      text: text.textContent, box: inset(text.getBoundingClientRect(), 1, 4),
    }));
    // The ring of the one that has the focus, too.
    const handles = all("[data-handle] > *").filter((mark) => getComputedStyle(mark).stroke !== "none")
      .map((mark) => inset(mark.getBoundingClientRect(), 2, 2));
    texts.forEach((one, k) => {
      if (outside(one.box, stage, 2)) tell(`“${one.text}” leaves the drawing`, where);
      texts.slice(k + 1).filter((other) => meet(one.box, other.box))
        .forEach((other) => tell(`“${one.text}” and “${other.text}” overlap`, where));
      if (handles.some((mark) => meet(one.box, mark))) tell(`“${one.text}” is under a handle`, where);
    });
    for (const layer of root.querySelectorAll(":scope > g")) {
      const clip = root.querySelector(layer.getAttribute("clip-path")?.slice(4, -1) ?? "none");
      const panel = clip ? clip.firstElementChild.getBBox() : { x: 0, y: 0, width: stage.width, height: stage.height };
      const edges = { left: panel.x, right: panel.x + panel.width, top: panel.y, bottom: panel.y + panel.height };
      for (const drawn of layer.querySelectorAll(":scope > :is(path, line, circle)")) {
        if (drawn.transform.baseVal.numberOfItems) continue;
        const { x, y, width, height } = drawn.getBBox();
        if (!width && !height) continue;
        const box = { left: x, right: x + width, top: y, bottom: y + height };
        if (outside(box, edges, 3)) tell(`a line of layer ${[...root.children].indexOf(layer)} leaves its panel`, where);
      }
    }
    const caption = picture.querySelector(".rs-caption");
    if (caption.scrollHeight > caption.clientHeight + 1) tell(`readout cut off: ${caption.textContent}`, where);
  }

  async function after(where, act) {
    picture.querySelector("[data-control=reset]").click();
    await frame();
    await act();
    await settled();
    look(where);
  }
  const give = (control, value) => {
    control.value = value;
    control.dispatchEvent(new Event("input"));
  };
  await after("the first state", () => {});
  for (const control of all(".rs-controls [data-control]")) {
    const name = control.dataset.control;
    if (control.type === "range") {
      for (const end of [control.min, control.max]) await after(`${name} at ${end}`, () => give(control, end));
    } else if (control.type === "select-one") {
      for (const { value } of control.options) await after(`${name}: ${value}`, () => give(control, value));
    } else if (!name.startsWith("play-")) {
      await after(name, () => control.click());
      await after(`${name}, five times, in the last choice`, async () => {
        for (const choice of all("select")) give(choice, choice.options[choice.options.length - 1].value);
        for (let k = 0; k < 5; k += 1) {
          control.click();
          await frame();
        }
      });
    }
  }
  await after("the first state", () => {});
  const names = withHandles ? all("[data-handle]").map((handle) => handle.dataset.handle) : [];
  for (const name of [...new Set([names[0], names[1], names.at(-1)].filter(Boolean))]) {
    for (const [across, up] of [[0, 0], [0.5, 0], [1, 0], [0, 0.5], [0.5, 0.5], [1, 0.5], [0, 1], [0.5, 1], [1, 1]]) {
      await after(`${name} at ${across}, ${up}`, () => {
        const { clientWidth: width, clientHeight: height } = picture.querySelector(".rs-stage");
        const handle = picture.querySelector(`[data-handle="${name}"]`);
        handle.focus({ focusVisible: true, preventScroll: true });
        handle.options.drag(across * width, up * height);
      });
    }
  }
  await after("the first state", () => {});
  return [...faults].map(([text, where]) => `${text} (${where})`);
}
