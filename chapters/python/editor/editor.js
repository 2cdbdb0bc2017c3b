import { closeBrackets, closeBracketsKeymap } from "@codemirror/autocomplete";
import { defaultKeymap, history, historyKeymap, indentWithTab } from "@codemirror/commands";
import { python } from "@codemirror/lang-python";
import { bracketMatching, indentOnInput, indentUnit, syntaxHighlighting } from "@codemirror/language";
import { EditorState, StateEffect, StateField } from "@codemirror/state";
import { Decoration, drawSelection, EditorView, keymap, lineNumbers } from "@codemirror/view";
import { tagHighlighter, tags } from "@lezer/highlight";
import { marked } from "marked";


/** Markdown as notebooks have it: with formulas between dollars. */
marked.use({
  extensions: [{
    name: "math",
    level: "inline",
    start: (text) => text.indexOf("$"),
    tokenizer(text) {
      const found = /^\$([^$\n]+)\$/.exec(text);
      return found && { type: "math", raw: found[0], text: found[1] };
    },
    renderer: ({ text }) => {
      const formula = text.replace(/&/g, "&amp;").replace(/</g, "&lt;");
      return `<span class="math notranslate nohighlight">\\(${formula}\\)</span>`;
    },
  }],
});

export { marked };

/** The classes of Pygments, so that code has the page's own colours. */
const COLOURS = tagHighlighter([
  { tag: tags.keyword, class: "k" },
  { tag: [tags.bool, tags.null], class: "kc" },
  { tag: tags.string, class: "s2" },
  { tag: tags.number, class: "mf" },
  { tag: tags.comment, class: "c1" },
  { tag: [tags.operator, tags.operatorKeyword], class: "o" },
  { tag: tags.function(tags.definition(tags.variableName)), class: "nf" },
  { tag: tags.definition(tags.className), class: "nc" },
]);

/** The line that an error names, until the code changes. */
const named = StateEffect.define();
const NAMED = Decoration.line({ class: "rs-named-line" });
const namedLine = StateField.define({
  create: () => Decoration.none,
  update(marks, { effects, docChanged, state: { doc } }) {
    const effect = effects.find((each) => each.is(named));
    if (!effect) return docChanged ? Decoration.none : marks;
    const { value } = effect;
    return value && value <= doc.lines ? Decoration.set([NAMED.range(doc.line(value).from)]) : Decoration.none;
  },
  provide: (field) => EditorView.decorations.from(field),
});

/**
 * An editor of Python in `parent`, with `code` to begin with. `label` names it, `hint` is the id
 * of the element that says how to run and to leave it. Shift and Enter call `run`. Tab indents;
 * after Escape it moves on, which is CodeMirror's own way.
 */
export function openEditor({ parent, code, label, hint, run }) {
  const runs = ["Shift-Enter", "Mod-Enter"].map((key) => ({ key, run: () => { run(); return true; } }));
  const view = new EditorView({
    parent,
    state: EditorState.create({
      doc: code,
      extensions: [
        lineNumbers(),
        namedLine,
        history(),
        drawSelection(),
        indentUnit.of("    "),
        indentOnInput(),
        bracketMatching(),
        closeBrackets(),
        python(),
        syntaxHighlighting(COLOURS),
        keymap.of([
          ...runs, ...closeBracketsKeymap, ...defaultKeymap, ...historyKeymap, indentWithTab,
        ]),
        EditorView.contentAttributes.of({ "aria-label": label, "aria-describedby": hint }),
      ],
    }),
  });
  return {
    mark: (line) => view.dispatch({ effects: named.of(line) }),
    code: () => view.state.doc.toString(),
    focus: () => view.focus(),
    close: () => view.destroy(),
  };
}
