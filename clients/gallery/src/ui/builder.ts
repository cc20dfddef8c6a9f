// Builds a condition from fields and from drawings in the player. Before the condition is applied, the
// builder shows how many animations match it and how many would be left.
import type { AppState, Loaded } from "../state/app-state";
import { missingIn, openRange, queryOf, type Box, type Condition } from "../state/conditions";
import { countsOf, orderedNames, within } from "../state/derived";
import { boxOfDrawn, type DrawnBox } from "../state/page";
import { button, el, field, select, setText } from "./dom";
import { histogram, spreadOf } from "./histogram";
import { rangeFields, type RangeFields } from "./range-fields";
import type { Part, Ui } from "./part";
import { makeStepForm, type StepForm } from "./step-form";
import { count, named } from "./words";

type Kind = "in" | "touches" | "ends" | "number";

const kinds: readonly { value: Kind; label: string }[] = [
  { value: "in", label: "Passes through a box" },
  { value: "touches", label: "Touches something" },
  { value: "ends", label: "Comes to rest in a box" },
  { value: "number", label: "A number is in a range" },
];
const builtDelayMs = 180;

export function makeBuilder(ui: Ui): Part {
  let kind: Kind = "in";
  let forms: StepForm[] = [];
  let drawsFor: StepForm | null = null;
  let put: DrawnBox | null = null;
  let number: { name: string; range: RangeFields; picture: HTMLElement } | null = null;
  let timer: ReturnType<typeof setTimeout> | undefined;

  const body = el("div", { class: "builder-body" });
  const text = el("code", { class: "built", id: "built-query" });
  const hint = el("p", { class: "hint", id: "built-hint" });
  const keep = button("Keep matching", () => apply(false), { id: "built-in", class: "primary" });
  const leave = button("Remove matching", () => apply(true), { id: "built-not" });
  const kindField = select(
    kinds,
    kind,
    (value) => {
      kind = value as Kind;
      begin();
    },
    { id: "built-kind" },
  );

  const condition = (): Condition => {
    if (kind === "number") return { kind, name: number?.name ?? "", range: number?.range.range ?? openRange };
    const first = forms[0];
    if (kind === "ends" && first !== undefined) return { kind, who: first.who, box: first.box };
    return { kind: "steps", steps: forms.map((form) => form.step) };
  };
  const changed = (): void => {
    const now = condition();
    const missing = missingIn(now);
    const query = missing === "" ? queryOf(now) : "";
    setText(text, query);
    if (missing !== "") setText(hint, missing);
    clearTimeout(timer);
    timer = setTimeout(() => ui.store.set({ built: query }), builtDelayMs);
    showCounts(ui.store.state);
    if (drawsFor !== null) putBox(drawsFor.box);
  };
  const apply = (isNot: boolean): void => {
    const query = missingIn(condition()) === "" ? queryOf(condition()) : "";
    if (query === "") return;
    ui.page.addChip(query, isNot);
    begin();
  };
  const begin = (): void => {
    const { loaded } = ui.store.state;
    stopDrawing();
    forms = [];
    number = null;
    body.replaceChildren();
    if (loaded === null) return;
    if (kind === "number") beginNumber(loaded);
    else addStep(loaded, kind);
    changed();
  };
  const addStep = (loaded: Loaded, stepKind: "in" | "touches" | "ends"): void => {
    const form = makeStepForm({
      scene: loaded.scene,
      looks: loaded.looks,
      kind: stepKind,
      title: forms.length === 0 ? "" : "then",
      onChange: changed,
      onDrawBox: (of) => draw(of, "box"),
      onMarkTime: (of) => draw(of, "time"),
      onRemove:
        forms.length === 0
          ? null
          : (of) => {
              forms = forms.filter((other) => other !== of);
              of.element.remove();
              changed();
            },
    });
    forms = [...forms, form];
    if (forms.length === 1) body.append(form.element, ...(stepKind === "ends" ? [] : [thenButtons(loaded)]));
    else body.insertBefore(form.element, body.lastElementChild);
  };
  const thenButtons = (loaded: Loaded): HTMLElement => {
    const add = (stepKind: "in" | "touches") => (): void => {
      addStep(loaded, stepKind);
      changed();
      forms.at(-1)?.element.querySelector("select")?.focus();
    };
    return el(
      "div",
      { class: "buttons" },
      button("Then passes through …", add("in"), { class: "small" }),
      button("Then touches …", add("touches"), { class: "small" }),
    );
  };
  const beginNumber = (loaded: Loaded): void => {
    const { numbers } = loaded.scene;
    const picture = el("div", { class: "spread" });
    const show = (name: string): void => {
      const unit = numbers.find((other) => other.name === name)?.unit ?? "1";
      const range = rangeFields(named(name, unit), "", 1, changed);
      number = { name, range, picture };
      body.replaceChildren(field("Number", choice), picture, range.element);
      showSpread(ui.store.state);
      changed();
    };
    const choice = select(
      numbers.map(({ name, unit }) => ({ value: name, label: named(name, unit) })),
      numbers[0]?.name ?? "",
      show,
      { id: "built-number" },
    );
    show(numbers[0]?.name ?? "");
  };
  const showSpread = (state: AppState): void => {
    if (number === null || state.loaded === null) return;
    const column = state.loaded.table.numbers.get(number.name);
    const spread = column === undefined ? null : spreadOf(column, within(state));
    number.picture.replaceChildren(
      spread === null
        ? "The animations shown have no value for this number."
        : histogram(spread, number.range.range, number.name),
    );
  };

  const draw = (form: StepForm, what: "box" | "time"): void => {
    const { state } = ui.store;
    drawsFor = form;
    const first = orderedNames(state)[0];
    if (state.page.playing.length === 0 && first !== undefined) ui.page.play([first]);
    ui.store.set({ drawing: { box: what === "box", time: what === "time" }, drawnRange: null });
    if (what === "box") putBox(form.box);
  };
  // Marks boxes that the builder sends to the player, so that they don't come back as boxes drawn by a
  // person.
  const putBox = (box: Box): void => {
    const drawn = drawable(box);
    if (drawn === null || JSON.stringify(drawn) === JSON.stringify(ui.store.state.drawnBox)) return;
    put = drawn;
    ui.store.set({ drawnBox: drawn });
  };
  const stopDrawing = (): void => {
    drawsFor = null;
    clearTimeout(timer);
    ui.store.set({ built: "", drawing: { box: false, time: false }, drawnBox: null, drawnRange: null });
  };

  const showCounts = (state: AppState): void => {
    const now = text.textContent ?? "";
    const error = state.answers.get(now)?.error;
    const counts = now === "" ? null : countsOf(state, now, null);
    const known = counts?.alone != null;
    setText(keep, known ? `Keep matching: ${count(counts.asIn ?? 0)} left` : "Keep matching");
    setText(leave, known ? `Remove matching: ${count(counts.asNot ?? 0)} left` : "Remove matching");
    keep.disabled = now === "" || error != null;
    leave.disabled = keep.disabled;
    if (now === "") return;
    setText(
      hint,
      error
        ? error.message
        : known
          ? `Alone, the condition matches ${count(counts.alone ?? 0)} of ${count(state.visible.length)}.`
          : "Counting …",
    );
  };
  let shown: Loaded | null = null;
  const update = (state: AppState, before: AppState): void => {
    if (state.loaded?.scene !== shown?.scene) {
      shown = state.loaded;
      begin();
      return;
    }
    if (state.drawnBox !== before.drawnBox && state.drawnBox !== null && state.drawnBox !== put)
      drawsFor?.setBox(boxOfDrawn(state.drawnBox));
    if (state.drawnRange !== before.drawnRange && state.drawnRange !== null)
      drawsFor?.setDuring(state.drawnRange);
    const isSame =
      state.answers === before.answers &&
      state.page.chips === before.page.chips &&
      within(state) === within(before) &&
      state.built === before.built;
    if (isSame) return;
    showCounts(state);
    showSpread(state);
  };
  const element = el(
    "section",
    { class: "builder", "aria-label": "Build a query" },
    el("h2", {}, "Build a query"),
    field("Condition", kindField),
    body,
    text,
    hint,
    el("div", { class: "buttons" }, keep, leave),
  );
  return { element, update };
}

/** Only a box that is bounded on all sides can be drawn. */
function drawable({ x, y, z }: Box): DrawnBox | null {
  if (x.low === null || y.low === null || z.low === null) return null;
  if (x.high === null || y.high === null || z.high === null) return null;
  if (x.low > x.high || y.low > y.high || z.low > z.high) return null;
  return { low: [x.low, y.low, z.low], high: [x.high, y.high, z.high] };
}
