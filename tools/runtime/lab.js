// What a course adds to JupyterLab in the browser. A student's own copy of an assignment hides the
// site's, also when that was corrected: here one is told, and may take the new one beside one's own.
// A reload keeps the open notebook, and Stop ends what runs.

const NARROW = 760;
/** The notebook to which the course has led: it has the page to itself. */
const opened = new URLSearchParams(location.search).get("path");
/** Where the pages' progress.js keeps what was done. */
const PROGRESS = "robust-slam-progress";
const {notebooks} = await (await fetched("releases.json", "no-cache")).json();
const app = await started();
await app.restored;
if (opened) document.head.append(Object.assign(document.createElement("style"), {
  textContent: ".jp-SideBar { display: none !important; }",
}));
if (opened || innerWidth < NARROW) keepClosed();
app.shell.currentChanged.connect((_, {newValue}) => turnTo(newValue));
await turnTo(app.shell.currentWidget);

async function started() {
  while (!window.jupyterapp) await new Promise((resolve) => setTimeout(resolve, 50));
  return window.jupyterapp;
}

/** Fetch a file beside this script; browsers keep some for days, unless they are told to ask. */
function fetched(path, cache) {
  return fetch(new URL(path, import.meta.url), {cache});
}

/** Close the side bar until the reader opens it: while it starts, the lab opens it once more. */
function keepClosed() {
  const close = () => {
    if (!app.shell.leftCollapsed) app.shell.collapseLeft();
  };
  close();
  app.shell.layoutModified.connect(close);
  const leave = () => app.shell.layoutModified.disconnect(close);
  for (const hand of ["pointerdown", "keydown"]) {
    addEventListener(hand, leave, {capture: true, once: true});
  }
}

async function turnTo(widget) {
  const context = widget?.context;
  if (!context) return;
  keepInAddress(context.path);
  context.sessionContext.kernelChanged.connect(letStopEndPython);
  letStopEndPython(context.sessionContext);
  context.saveState.connect(noteCheck);
  await look(context);
}

/** Tell the course's pages, where the saved notebook says that all visible cases have passed. */
function noteCheck(context, state) {
  if (state !== "completed" || !notebooks[context.path]) return;
  const checks = context.model.toJSON().cells.filter(({source}) => source.includes("self_check"));
  const said = JSON.stringify(checks.map(({outputs}) => outputs ?? []));
  if (!said.includes("All visible cases passed")) return;
  const kept = JSON.parse(localStorage.getItem(PROGRESS)) ?? {};
  const name = context.path.replace(".ipynb", "");
  const done = {...kept.assignments?.[name], checked: true};
  localStorage.setItem(PROGRESS, JSON.stringify({...kept, assignments: {...kept.assignments, [name]: done}}));
}

/** The lab takes the path out of the address; there, a reload opens the notebook again. */
function keepInAddress(path) {
  const address = new URL(location);
  address.searchParams.set("path", path);
  history.replaceState(history.state, "", address);
}

/** Nothing reaches Python in a browser while it computes: as on the pages, Stop ends it. */
function letStopEndPython(context) {
  const kernel = context.session?.kernel;
  if (!kernel) return;
  kernel.interrupt = async () => {
    await context.restartKernel();
    await notify("Stopped, and Python with it. What you wrote stays; run the cells above again.");
  };
}

const notify = (message) => app.commands.execute("apputils:notify", {
  message, type: "info", options: {autoClose: false},
});

async function look(context) {
  const release = notebooks[context?.path];
  if (!release) return;
  await context.ready;
  const mine = context.model.getMetadata("robust_slam")?.release;
  const key = `robust-slam-kept:${context.path}`;
  if (mine === release || localStorage.getItem(key) === release) return;
  const answer = await ask(context.path);
  if (answer === "keep") localStorage.setItem(key, release);
  if (answer === "take") await take(context);
}

/** Ask what is to become of an older copy: "take", "keep", or "" to be asked again. */
function ask(path) {
  const dialog = document.createElement("dialog");
  dialog.innerHTML = `<form method="dialog" style="max-width: 28em; font: 15px/1.5 sans-serif">
    <p><b></b> has been corrected since you opened it. Your copy is the older one.</p>
    <p>Take the new one, and your copy stays beside it under another name, with all that you wrote:
    copy your functions over. Or go on with your own; the tests that count are the same.</p>
    <button value="take">Take the new one</button> <button value="keep">Keep mine</button></form>`;
  dialog.querySelector("b").textContent = path;
  document.body.append(dialog);
  dialog.showModal();
  return new Promise((resolve) => {
    dialog.addEventListener("close", () => {
      dialog.remove();
      resolve(dialog.returnValue);
    });
  });
}

/** Move the open copy to a name that is free, and open the site's under the old name. */
async function take(context) {
  const {contents} = app.serviceManager;
  const path = context.path;
  await context.save();
  const there = new Set((await contents.get("", {content: true})).content.map((each) => each.path));
  let kept = path.replace(".ipynb", "-mine.ipynb");
  for (let number = 2; there.has(kept); number++) {
    kept = path.replace(".ipynb", `-mine-${number}.ipynb`);
  }
  await contents.rename(path, kept);
  await fetched(`files/${path}`, "reload");
  await app.commands.execute("docmanager:open", {path});
  await notify(`Your work is in ${kept}. ${path} is the new one.`);
}
