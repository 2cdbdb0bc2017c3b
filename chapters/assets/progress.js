// Remembers in the browser what was chosen in quizzes and predictions, which chapters were read and
// where the reader stopped, and which assignments were opened, downloaded and, by the lab, checked.
// Ticks say so in the sidebar and at the assignments' links, and one place shows all of it and saves
// it as a file. Without this script, or where the browser keeps nothing, all pages work.
(() => {
  const KEY = "robust-slam-progress";
  const page = DOCUMENTATION_OPTIONS.pagename;
  const forms = [...document.querySelectorAll("form[data-question]")];
  const quiz = forms.filter((form) => form.closest(".rs-quiz"));
  const links = [...document.querySelectorAll("article a[href]")]
    .map((link) => ({link, ...assignmentOf(link)}))
    .filter(({name}) => name);

  let forgotten = false; // then this page is not the last place again as soon as it is scrolled
  const place = document.querySelector(".rs-progress");
  const chapters = [...document.querySelectorAll(".bd-links a")]
    .map((link) => ({link, title: link.textContent.trim(), name: nameOf(link)}));

  // The name of the page to which a link of the sidebar leads.
  function nameOf(link) {
    const [folder, file] = link.pathname.replace(/\.html$/, "").split("/").slice(-2);
    return `${folder}/${file}`;
  }

  // What is kept: of quizzes by pages the chosen letters by questions, and whether all of them are
  // right; of assignments by names what was done with them; the pages that were read to their end;
  // and the page, with the heading there, at which the reader was last.
  function read() {
    try {
      return known(JSON.parse(localStorage.getItem(KEY)));
    } catch {
      return known(null); // what is no JSON is as good as nothing
    }
  }

  function known(value) {
    const {quizzes, assignments, read, last} = value ?? {};
    const page = typeof last?.page === "string" ? last : null;
    return {quizzes: {...quizzes}, assignments: {...assignments}, read: {...read}, last: page};
  }

  function write(kept) {
    localStorage.setItem(KEY, JSON.stringify(kept));
  }

  // Whether the browser keeps anything here. It is tried under a key of its own, because what a
  // page reads while another one writes may be older than what is kept.
  function keeps() {
    try {
      localStorage.setItem(`${KEY}-tried`, "");
      localStorage.removeItem(`${KEY}-tried`);
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
    const done = quiz.length > 0 && quiz.every(isRight);
    change((kept) => { kept.quizzes[page] = {choices, done}; });
  }

  function rememberAssignment(name, done) {
    change((kept) => { kept.assignments[name] = {...kept.assignments[name], [done]: true}; });
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
    const {quizzes, assignments, read: pages} = read();
    for (const {link, name} of chapters) {
      if (quizzes[name]?.done) tick(link, true, "quiz done");
      else tick(link, pages[name], "read", "·");
    }
    for (const {link, name, done} of links) tick(link, assignments[name]?.[done], done);
    if (place) showAll();
    // The first door of the home page leads on.
    const [door, link] = [document.querySelector(".rs-doors p"), goOn()];
    if (!door || !link) return;
    door.style.minHeight = `${door.offsetHeight}px`; // nothing below moves
    door.replaceChildren(element("strong", {}, "Go on"), " with ", link);
  }

  function tick(link, isDone, words, sign = "✓") {
    link.querySelector(".rs-done")?.remove();
    if (!isDone) return;
    sign = element("span", {role: "img", ariaLabel: words, title: words}, sign);
    link.append(element("span", {className: "rs-done"}, "\u00a0", sign));
  }

  // A page is read when its end is in view; until then the place is its last heading above.
  function rememberReading() {
    const article = document.querySelector("article");
    const entry = chapters.find(({name}) => name === page);
    if (!article || !entry || place) return;
    const end = element("span");
    article.append(end);
    new IntersectionObserver(([{isIntersecting}]) => {
      if (isIntersecting) change((kept) => { kept.read[page] = true; });
    }).observe(end);
    const sections = [...article.querySelectorAll("section[id]")];
    addEventListener("scrollend", () => {
      if (forgotten) return;
      const above = sections.findLast((each) => each.getBoundingClientRect().top < innerHeight / 3);
      if (above) change((kept) => { kept.last = {page, id: above.id}; });
    });
  }

  function change(edit) {
    const kept = read();
    edit(kept);
    write(kept);
    mark();
  }

  // A link to where the reader was last.
  function goOn() {
    const {last} = read();
    const found = chapters.find(({name}) => name === last?.page);
    return found && element("a", {href: `${found.link.href}#${last.id}`}, found.title);
  }

  // One row for each chapter, and what can be done with all of it.
  function showAll() {
    const {quizzes, assignments, read: pages} = read();
    const numbered = chapters.filter(({name}) => /^chapters\/\d\d-/.test(name));
    const rows = numbered.map(({link, title, name}) => {
      const done = Object.entries(assignments[name.split("/")[1]] ?? {});
      const answers = Object.keys(quizzes[name]?.choices ?? {}).length;
      return row("td", {}, [
        element("a", {href: link.href}, title),
        pages[name] ? "read" : "",
        quizzes[name]?.done ? "all right" : answers ? `${answers} answered` : "",
        done.filter(([, is]) => is).map(([what]) => what).join(", "),
      ]);
    });
    const heads = row("th", {scope: "col"}, ["chapter", "text", "quiz", "assignment"]);
    const link = goOn();
    const line = element("p", {}, ...link ? ["You were last at ", link, "."] : []);
    place.querySelector(".rs-all")?.remove();
    const table = element("table", {className: "table"}, heads, ...rows);
    place.prepend(element("div", {className: "rs-all"}, line, table));
    place.hidden = false;
  }

  function row(kind, properties, cells) {
    return element("tr", {}, ...cells.map((content) => element(kind, properties, content)));
  }

  function save() {
    const href = URL.createObjectURL(new Blob([JSON.stringify(read(), null, 1)]));
    element("a", {href, download: `${KEY}.json`}).click();
    URL.revokeObjectURL(href);
  }

  // What the file has is added to what is kept here, and counts more.
  async function load(file) {
    const text = await file.text();
    try {
      const [mine, theirs] = [read(), JSON.parse(text)];
      if (!theirs?.quizzes || !theirs?.assignments) throw new TypeError();
      const value = known(theirs);
      for (const part of ["quizzes", "assignments", "read"]) value[part] = {...mine[part], ...value[part]};
      write({...value, last: value.last ?? mine.last});
      restore();
      return `${file.name} is loaded.`;
    } catch {
      return `${file.name} is no file of progress; nothing has changed. Choose one that was saved here.`;
    }
  }

  function offerAFile() {
    const line = forgetting();
    const [button, said] = line.children;
    const input = element("input", {type: "file", accept: ".json", hidden: true});
    input.addEventListener("change", async () => {
      said.textContent = await load(input.files[0]);
      input.value = "";
    });
    button.before(
      pressable("Save as a file", save), " ", pressable("Load a file", () => input.click()), " ", input,
    );
    place.append(line);
  }

  // The button to forget stands below each quiz, and below a list of assignments.
  function offerToForget() {
    for (const quiz of document.querySelectorAll(".rs-quiz")) quiz.append(forgetting());
    const tables = new Set(links.map(({link}) => link.closest("table")).filter(Boolean));
    if (place) offerAFile();
    else for (const table of tables) {
      (table.closest(".pst-scrollable-table-container") ?? table).after(forgetting());
    }
  }

  function forgetting() {
    const said = element("span", {role: "status"}, "Your answers to the quizzes of all chapters, what you have read, code that you have"
      + " changed, and which assignments you have opened and downloaded, are kept in this browser and are sent nowhere.");
    const button = pressable("Forget my progress", () => {
      for (const key of Object.keys(localStorage)) if (/^robust-slam-(progress|code)/.test(key)) localStorage.removeItem(key);
      forgotten = true;
      restore();
      said.textContent = "Your answers are forgotten, what you have read, opened and downloaded."
        + " Notebooks of assignments stay in the browser.";
    });
    return element("p", {className: "rs-forget"}, button, " ", said);
  }

  function pressable(name, does) {
    const button = element("button", {type: "button"}, name);
    button.addEventListener("click", does);
    return button;
  }

  if (!keeps()) return;
  offerToForget();
  rememberReading();
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
  // A page that the browser took from its memory may be older than what is kept, and to one that is
  // gone back to it brings the choices of then.
  addEventListener("pageshow", restore);
  addEventListener("storage", restore); // another tab has written
})();
