// Remembers in the browser what was chosen in quizzes and predictions, and which assignments were
// opened and downloaded; ticks say so in the sidebar and at the assignments' links. Without this
// script, or where the browser keeps nothing, all of them work.
(() => {
  const KEY = "robust-slam-progress";
  const page = DOCUMENTATION_OPTIONS.pagename;
  const forms = [...document.querySelectorAll("form[data-question]")];
  const quiz = forms.filter((form) => form.closest(".rs-quiz"));
  const links = [...document.querySelectorAll("article a[href]")]
    .map((link) => ({link, ...assignmentOf(link)}))
    .filter(({name}) => name);

  // What is kept: of quizzes by pages the chosen letters by questions, and whether all of them are
  // right; of assignments by names what was done with them.
  function read() {
    let kept = {};
    try {
      kept = JSON.parse(localStorage.getItem(KEY)) ?? {};
    } catch {
      // What is no JSON is as good as nothing.
    }
    return {quizzes: {...kept.quizzes}, assignments: {...kept.assignments}};
  }

  function write(kept) {
    try {
      localStorage.setItem(KEY, JSON.stringify(kept));
      return true;
    } catch {
      return false;
    }
  }

  // The assignment that a link leads to, and what is done with it there.
  function assignmentOf(link) {
    const zip = /\/assignments\/([\w-]+)\.zip$/.exec(link.pathname);
    if (zip) return {name: zip[1], done: "downloaded"};
    const path = new URLSearchParams(link.search).get("path") ?? "";
    const opened = /\/lab\/lab\/index\.html$/.test(link.pathname) && /^([\w-]+)\.ipynb$/.exec(path);
    return opened ? {name: opened[1], done: "opened"} : {};
  }

  function isRight(form) {
    return Boolean(form.querySelector(".rs-option:has(:checked) .rs-correct"));
  }

  function rememberAnswers() {
    const chosen = (form) => form.querySelector(":checked")?.value;
    const entries = forms.map((form) => [form.dataset.question, chosen(form)]);
    const choices = Object.fromEntries(entries.filter(([, letter]) => letter));
    const kept = read();
    kept.quizzes[page] = {choices, done: quiz.length > 0 && quiz.every(isRight)};
    write(kept);
    mark();
  }

  function rememberAssignment(name, done) {
    const kept = read();
    kept.assignments[name] = {...kept.assignments[name], [done]: true};
    write(kept);
    mark();
  }

  function restore() {
    const choices = read().quizzes[page]?.choices ?? {};
    for (const form of forms) {
      for (const input of form.querySelectorAll("input")) {
        input.checked = choices[form.dataset.question] === input.value;
      }
    }
    mark();
  }

  function mark() {
    const {quizzes, assignments} = read();
    const right = Object.keys(quizzes).filter((name) => quizzes[name].done);
    for (const link of document.querySelectorAll(".bd-links a")) {
      const path = link.pathname.replace(/\.html$/, "");
      tick(link, right.some((name) => path.endsWith(`/${name}`)), "quiz done");
    }
    for (const {link, name, done} of links) tick(link, assignments[name]?.[done], done);
  }

  function tick(link, isDone, words) {
    link.querySelector(".rs-done")?.remove();
    if (!isDone) return;
    const [done, sign] = [document.createElement("span"), document.createElement("span")];
    done.className = "rs-done";
    sign.setAttribute("role", "img");
    sign.setAttribute("aria-label", words);
    sign.title = words;
    sign.textContent = "✓";
    done.append("\u00a0", sign);
    link.append(done);
  }

  // The button stands below each quiz, and below a list of assignments.
  function offerToForget() {
    for (const quiz of document.querySelectorAll(".rs-quiz")) quiz.append(forgetting());
    const tables = new Set(links.map(({link}) => link.closest("table")).filter(Boolean));
    for (const table of tables) {
      (table.closest(".pst-scrollable-table-container") ?? table).after(forgetting());
    }
  }

  function forgetting() {
    const line = document.createElement("p");
    const button = document.createElement("button");
    const said = document.createElement("span");
    line.className = "rs-forget";
    button.type = "button";
    button.textContent = "Forget my progress";
    said.setAttribute("role", "status");
    said.textContent = "Your answers to the quizzes of all chapters, and which assignments you have"
      + " opened and downloaded, are kept in this browser and are sent nowhere.";
    button.addEventListener("click", () => {
      localStorage.removeItem(KEY);
      restore();
      said.textContent = "Your answers are forgotten, and what you have opened and downloaded."
        + " Notebooks of assignments stay in the browser.";
    });
    line.append(button, " ", said);
    return line;
  }

  if (!write(read())) return;
  offerToForget();
  for (const form of forms) {
    form.addEventListener("change", rememberAnswers);
    // The event comes before the boxes are empty.
    form.addEventListener("reset", () => setTimeout(rememberAnswers));
  }
  for (const {link, name, done} of links) {
    // A middle click opens a link too, and is no click.
    for (const kind of ["click", "auxclick"]) {
      link.addEventListener(kind, ({button}) => button < 2 && rememberAssignment(name, done));
    }
  }
  restore();
  // A page that the browser took from its memory may be older than what is kept.
  addEventListener("pageshow", (event) => event.persisted && restore());
})();
