(() => {
  "use strict";
  const REST = 600; // ms without a change after which the new state is spoken
  const BEAT = 900; // ms from one step to the next while playing
  const calm = window.matchMedia("(prefers-reduced-motion: reduce)");

  const position = (control) => Number(control.type === "checkbox" ? control.checked : control.value);

  function row([name, value]) {
    const tr = document.createElement("tr");
    const th = tr.appendChild(document.createElement("th"));
    th.scope = "row";
    th.textContent = name;
    tr.appendChild(document.createElement("td")).textContent = value;
    return tr;
  }

  function say(control) {
    if (!control.dataset.texts) return;
    const text = JSON.parse(control.dataset.texts)[position(control)];
    if (control.type === "range") {
      control.setAttribute("aria-valuetext", text);
      control.nextElementSibling.textContent = text;
    } else {
      control.textContent = text;
    }
  }

  function begin(canvas) {
    canvas.dataset.ready = "";
    const find = (selector) => canvas.querySelector(selector);
    const frames = JSON.parse(find(".rs-frames").textContent);
    const controls = [...canvas.querySelectorAll("[data-stride]")];
    const image = find("img");
    let rest = 0;

    // On a reload Firefox keeps what was ticked, while the picture is the first one again.
    controls.forEach((c) => { if (c.type === "checkbox") c.checked = c.defaultChecked; });

    function show() {
      const index = controls.reduce((sum, c) => sum + position(c) * Number(c.dataset.stride), 0);
      const { svg, text, rows } = frames[index];
      image.src = "data:image/svg+xml;charset=utf-8," + encodeURIComponent(svg);
      image.alt = find("figcaption").textContent = text;
      find("tbody")?.replaceChildren(...rows.map(row));
      controls.forEach(say);
      clearTimeout(rest);
      rest = setTimeout(() => { find(".rs-spoken").textContent = text; }, REST);
    }

    canvas.querySelectorAll(".rs-stepper").forEach((stepper) => walk(stepper, show));
    canvas.addEventListener("input", show);
    // JupyterLab leaves the keys to an element that carries this.
    canvas.querySelectorAll("input, select, button, summary").forEach((element) => {
      element.dataset.lmSuppressShortcuts = "true";
    });
    find("fieldset").disabled = false;
    find(".rs-note").hidden = true;
  }

  function walk(stepper, show) {
    const at = stepper.querySelector("[data-stride]");
    const button = (does) => stepper.querySelector(`[data-does=${does}]`);
    const last = Number(at.max ?? at.dataset.max);
    const play = button("play");
    let timer = 0;

    // A button that cannot go on keeps the keyboard's focus, so it is not disabled outright.
    function go(step) {
      at.value = step;
      button("step")?.setAttribute("aria-disabled", String(step >= last));
      show();
    }
    function pause() {
      clearInterval(timer);
      timer = 0;
      if (play) play.textContent = "Play";
    }
    function next() {
      if (position(at) < last) go(position(at) + 1);
      if (position(at) >= last) pause();
    }
    function toggle() {
      if (timer) return pause();
      if (position(at) >= last) go(0);
      play.textContent = "Pause";
      timer = setInterval(next, BEAT);
    }
    function offer() {
      play.hidden = calm.matches;
      if (calm.matches) pause();
    }

    at.addEventListener("input", pause); // a slider that is moved by hand
    button("step")?.addEventListener("click", () => { pause(); next(); });
    button("restart")?.addEventListener("click", () => { pause(); go(0); });
    if (play) {
      play.addEventListener("click", toggle);
      calm.addEventListener("change", offer);
      offer();
    }
  }

  document.querySelectorAll(".rs-canvas:not([data-ready])").forEach(begin);
})();
