// Formats numbers for people.

const counts = new Intl.NumberFormat("en", { maximumFractionDigits: 0 });

export const noPictures =
  "This browser has no WebGL, so animations cannot be drawn. Their numbers are still available.";

export function count(value: number): string {
  return counts.format(value);
}

export function counted(value: number, one: string, many: string): string {
  return `${count(value)} ${value === 1 ? one : many}`;
}

/** A number with `digits` significant digits: "0.0123", "−12.35", "1.2e−9". */
export function number(value: number, digits = 4): string {
  if (Number.isNaN(value)) return "none";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  const isWhole = Number.isInteger(value) && Math.abs(value) < 1e15;
  return String(isWhole ? value : Number(value.toPrecision(digits))).replace("-", "−");
}

/** A number short enough for a card: three significant digits, at most two decimals. */
export function cardNumber(value: number): string {
  return number(Number.isFinite(value) ? Number(value.toFixed(2)) : value, 3);
}

const shownUnits: Readonly<Record<string, string>> = { "m s-1": "m/s", "rad s-1": "rad/s", "1": "" };

export function withUnit(value: number, unit: string): string {
  const shown = shownUnits[unit] ?? unit;
  return shown === "" ? number(value) : `${number(value)} ${shown}`;
}

/** A number's name with its unit: "rest_s [s]". */
export function named(name: string, unit: string): string {
  const shown = shownUnits[unit] ?? unit;
  return shown === "" ? name : `${name} [${shown}]`;
}

export function millimetres(metres: number): string {
  return `${number(Number((metres * 1000).toPrecision(3)))} mm`;
}

export function seconds(value: number, digits = 3): string {
  return `${value.toFixed(digits).replace("-", "−")} s`;
}

/** "12 ± 2 %", or "12 %" if the error isn't known. */
export function share(value: number, error: number | null): string {
  const isKnown = error !== null && Number.isFinite(error);
  const digits = isKnown && error < 0.01 ? 1 : 0;
  const percent = (100 * value).toFixed(digits);
  return isKnown ? `${percent} ± ${(100 * error).toFixed(digits)} %` : `${percent} %`;
}
