// Creates elements. Text is always inserted as text, so names from archives never become markup.

export type Child = Node | string | null;

type Handlers = { [Name in keyof HTMLElementEventMap]?: (event: HTMLElementEventMap[Name]) => void };

export interface Properties {
  readonly class?: string;
  readonly on?: Handlers;
  /** Attributes. null omits an attribute; true sets it without a value. */
  readonly [attribute: string]: string | number | boolean | null | undefined | Handlers;
}

export function el<Tag extends keyof HTMLElementTagNameMap>(
  tag: Tag,
  properties: Properties = {},
  ...children: Child[]
): HTMLElementTagNameMap[Tag] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name === "on") listen(element, value as Handlers);
    else if (typeof value !== "object") setAttribute(element, name, value);
  }
  for (const child of children) if (child !== null) element.append(child);
  return element;
}

function listen(element: HTMLElement, handlers: Handlers): void {
  for (const [name, handler] of Object.entries(handlers))
    if (handler !== undefined) element.addEventListener(name, handler as EventListener);
}

/** null, undefined and false remove the attribute. */
export function setAttribute(
  element: Element,
  name: string,
  value: string | number | boolean | null | undefined,
): void {
  if (value === null || value === undefined || value === false) element.removeAttribute(name);
  else element.setAttribute(name, value === true ? "" : String(value));
}

/** Changes text only if it differs, so that live regions and text selections aren't disturbed. */
export function setText(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

export function setHidden(element: HTMLElement, isHidden: boolean): void {
  if (element.hidden !== isHidden) element.hidden = isHidden;
}

export function button(
  label: string,
  onClick: (event: MouseEvent) => void,
  properties: Properties = {},
): HTMLButtonElement {
  return el("button", { type: "button", ...properties, on: { click: onClick } }, label);
}

/** A button with an icon. `label` is its accessible name and its tooltip. */
export function iconButton(
  icon: IconName,
  label: string,
  onClick: (event: MouseEvent) => void,
  properties: Properties = {},
): HTMLButtonElement {
  const element = el("button", {
    type: "button",
    "aria-label": label,
    title: label,
    ...properties,
    on: { click: onClick },
  });
  element.classList.add("icon-button");
  element.append(iconOf(icon));
  return element;
}

const icons = {
  play: "M4 2.5v11l9-5.5z",
  pause: "M4 2.5h3v11H4zM9 2.5h3v11H9z",
  frameBack: "M11 3v10L5 8zM3 3h1.6v10H3z",
  frameOn: "M5 3v10l6-5zM11.4 3H13v10h-1.6z",
  eventBack: "M8.5 3v10L3.5 8zM13.5 3v10l-5-5zM2 3h1.5v10H2z",
  eventOn: "M7.5 3v10l5-5zM2.5 3v10l5-5zM12.5 3H14v10h-1.5z",
  star: "M8 1.4l2 4.3 4.7.6-3.5 3.2.9 4.7L8 11.9l-4.1 2.3.9-4.7L1.3 6.3 6 5.7z",
  close: "M3.4 2.3 8 6.9l4.6-4.6 1.1 1.1L9.1 8l4.6 4.6-1.1 1.1L8 9.1l-4.6 4.6-1.1-1.1L6.9 8 2.3 3.4z",
  check: "M6.3 12.4 2.2 8.3l1.2-1.2 2.9 2.9 6.3-6.3 1.2 1.2z",
  eyeOff: "M1.5 8S4 3.5 8 3.5 14.5 8 14.5 8 12 12.5 8 12.5 1.5 8 1.5 8zM3 2l1-1 10 13-1 1z",
  pencil: "M2.5 10.8l7.6-7.6 2.7 2.7-7.6 7.6-3.2.5z",
} as const;

export type IconName = keyof typeof icons;

export function iconOf(name: IconName): SVGSVGElement {
  const svg = svgEl("svg", {
    viewBox: "0 0 16 16",
    "aria-hidden": "true",
    class: "icon",
    focusable: "false",
  });
  svg.append(svgEl("path", { d: icons[name] }));
  return svg;
}

export function svgEl<Tag extends keyof SVGElementTagNameMap>(
  tag: Tag,
  attributes: Readonly<Record<string, string | number>>,
  ...children: Child[]
): SVGElementTagNameMap[Tag] {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  for (const child of children) if (child !== null) element.append(child);
  return element;
}

let fields = 0;

export function field(label: string, input: HTMLElement, properties: Properties = {}): HTMLElement {
  if (input.id === "") {
    fields += 1;
    input.id = `field-${fields}`;
  }
  return el("div", { class: "field", ...properties }, el("label", { for: input.id }, label), input);
}

export interface Choice {
  readonly value: string;
  readonly label: string;
}

export function select(
  choices: readonly Choice[],
  value: string,
  onChange: (value: string) => void,
  properties: Properties = {},
): HTMLSelectElement {
  const element = el("select", { ...properties, on: { change: () => onChange(element.value) } });
  setChoices(element, choices, value);
  return element;
}

export function setChoices(element: HTMLSelectElement, choices: readonly Choice[], value: string): void {
  element.replaceChildren(...choices.map((choice) => el("option", { value: choice.value }, choice.label)));
  element.value = value;
}
