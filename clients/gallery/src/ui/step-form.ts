// The form for one step of a condition: bodies, box or contact, and time.
import type { Looks, Scene } from "../data/types";
import {
  kindsOfBodies,
  openRange,
  type Box,
  type Range,
  type Step,
  type Who,
} from "../state/conditions";
import { button, el, field, select, type Choice } from "./dom";
import { boxOfPlace } from "../state/places";
import { bodySwatches, placeMap } from "./place-map";
import { rangeFields } from "./range-fields";

export interface StepForm {
  readonly element: HTMLElement;
  readonly step: Step;
  /** For "ends": the bodies that come to rest in `box`. Their time of rest doesn't matter. */
  readonly who: Who;
  readonly box: Box;
  setWho(name: string): void;
  setBox(box: Box): void;
  setDuring(range: Range): void;
}

export interface StepOptions {
  readonly scene: Scene;
  readonly looks: Looks;
  readonly kind: "in" | "touches" | "ends";
  /** "" if the condition has only one step. */
  readonly title: string;
  readonly onChange: () => void;
  /** Requests that a person draws a box, or marks a time range, for this form. */
  readonly onDrawBox: (form: StepForm) => void;
  readonly onMarkTime: (form: StepForm) => void;
  readonly onRemove: ((form: StepForm) => void) | null;
}

export function makeStepForm(options: StepOptions): StepForm {
  const { scene, looks, kind, onChange } = options;
  const who = select(whoChoices(scene), defaultWho(scene), onChange);
  const partners = scene.features
    .filter((feature) => feature.kind !== "wanted")
    .map(({ name }) => choice(name));
  const partner = select([{ value: "", label: "anything" }, ...partners], "", onChange);
  const axes = (["x", "y", "z"] as const).map((axis) =>
    rangeFields(axis, "mm", 1000, onChange),
  );
  const during = rangeFields("time", "s", 1, onChange);

  const boxOf = (): Box => {
    const [x, y, z] = axes.map((fields) => fields.range);
    return { x: x ?? openRange, y: y ?? openRange, z: z ?? openRange };
  };
  const swatches = bodySwatches(scene, looks, (name) => form.setWho(name));
  const parts: HTMLElement[] = [field("Body", who), ...(swatches === null ? [] : [swatches])];
  if (kind === "touches") parts.push(field("Touches", partner));
  else {
    const map = placeMap(scene, looks, (place) => form.setBox(boxOfPlace(place)));
    parts.push(
      ...(map === null ? [] : [map]),
      el("div", { class: "box-fields" }, ...axes.map(({ element }) => element)),
      button("Draw box in player", () => options.onDrawBox(form), { class: "draw-box" }),
    );
  }
  if (kind !== "ends") {
    parts.push(
      el(
        "details",
        {},
        el("summary", {}, "Limit the time"),
        during.element,
        button("Mark range on timeline", () => options.onMarkTime(form), { class: "mark-time" }),
      ),
    );
  }
  const { onRemove } = options;
  if (onRemove !== null) parts.push(button("Delete step", () => onRemove(form), { class: "small" }));
  const form: StepForm = {
    element: el(
      "fieldset",
      { class: "step" },
      options.title === "" ? null : el("legend", {}, options.title),
      ...parts,
    ),
    get who() {
      return whoOf(who.value);
    },
    get box() {
      return boxOf();
    },
    get step(): Step {
      const common = { who: whoOf(who.value), during: during.range };
      return kind === "touches"
        ? { kind, ...common, partner: partner.value }
        : { kind: "in", ...common, box: boxOf() };
    },
    setWho(name) {
      who.value = `body:${name}`;
      onChange();
    },
    setBox(box) {
      (["x", "y", "z"] as const).forEach((axis, i) => axes[i]?.set(box[axis]));
      onChange();
    },
    setDuring(range) {
      during.element.closest("details")?.setAttribute("open", "");
      during.set(range);
      onChange();
    },
  };
  return form;
}

function bodyNames(scene: Scene): string[] {
  return scene.features.filter((feature) => feature.kind === "body").map(({ name }) => name);
}

function choice(name: string): Choice {
  return { value: name, label: name };
}

function whoChoices(scene: Scene): Choice[] {
  const names = bodyNames(scene);
  const bodies = names.map((name) => ({ value: `body:${name}`, label: name }));
  const kinds = kindsOfBodies(names);
  // If all bodies are of one kind, "any body" means the same.
  const ofKinds = kinds.length > 1 ? kinds : [];
  return [
    { value: "any:", label: "any body" },
    { value: "every:", label: "every body" },
    ...ofKinds.flatMap((kind) => [
      { value: `any:${kind}`, label: `any ${kind}` },
      { value: `every:${kind}`, label: `every ${kind}` },
    ]),
    ...bodies,
  ];
}

function defaultWho(scene: Scene): string {
  const names = bodyNames(scene);
  return names.length === 1 ? `body:${names[0] ?? ""}` : "any:";
}

function whoOf(value: string): Who {
  const at = value.indexOf(":");
  const kind = value.slice(0, at);
  const rest = value.slice(at + 1);
  if (kind === "body") return { kind, name: rest };
  return { kind: kind === "every" ? "every" : "any", of: rest };
}
