// Remembers in the browser what was chosen in the quizzes, and marks in the sidebar the chapters
// whose quiz is done. Without this script, or where the browser keeps nothing, the quizzes work.
(() => {
  const KEY = "robust-slam-quizzes";
  const page = DOCUMENTATION_OPTIONS.pagename;
  const forms = [...document.querySelectorAll(".rs-quiz form")];

  // What is kept, by pages: the chosen letters by questions, and whether all of them are right.
  function read() {
    try {
      return JSON.parse(localStorage.getItem(KEY)) ?? {};
    } catch {
      return {};
    }
  }

  function write(kept) {
    try {
      localStorage.setItem(KEY, JSON.stringify(kept));
      return true;
    } catch {
      return false;
    }
  }

  function isRight(form) {
    return Boolean(form.querySelector(".rs-option:has(:checked) .rs-right"));
  }

  function remember() {
    const entries = forms.map((form) => [form.dataset.question, form.elements.choice.value]);
    const choices = Object.fromEntries(entries.filter(([, letter]) => letter));
    write({...read(), [page]: {choices, done: forms.every(isRight)}});
    mark();
  }

  function restore() {
    const choices = read()[page]?.choices ?? {};
    for (const form of forms) {
      for (const input of form.elements.choice) {
        input.checked = choices[form.dataset.question] === input.value;
      }
    }
    mark();
  }

  function mark() {
    const kept = read();
    const done = Object.keys(kept).filter((name) => kept[name].done);
    for (const link of document.querySelectorAll(".bd-links a")) {
      link.querySelector(".rs-done")?.remove();
      const path = link.pathname.replace(/\.html$/, "");
      if (!done.some((name) => path.endsWith(`/${name}`))) continue;
      const tick = document.createElement("span");
      tick.className = "rs-done";
      tick.setAttribute("role", "img");
      tick.setAttribute("aria-label", "quiz done");
      tick.title = "quiz done";
      tick.textContent = "✓";
      link.append(" ", tick);
    }
  }

  function offerToForget(quiz) {
    const line = document.createElement("p");
    const button = document.createElement("button");
    const said = document.createElement("span");
    line.className = "rs-forget";
    button.type = "button";
    button.textContent = "Forget my answers";
    said.setAttribute("role", "status");
    said.textContent =
      "Your answers to the quizzes of all chapters are kept in this browser and are sent nowhere.";
    button.addEventListener("click", () => {
      localStorage.removeItem(KEY);
      restore();
      said.textContent = "Your answers to the quizzes of all chapters are forgotten.";
    });
    line.append(button, " ", said);
    quiz.append(line);
  }

  if (!write(read())) return;
  document.querySelectorAll(".rs-quiz").forEach(offerToForget);
  for (const form of forms) form.addEventListener("change", remember);
  restore();
  // A page that the browser took from its memory may be older than what is kept.
  addEventListener("pageshow", (event) => event.persisted && restore());
})();
