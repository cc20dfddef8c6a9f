// Line styles of chains: chains differ in colour and in dash pattern.

/** Colours that colour-blind people can distinguish (Okabe and Ito), dark enough on light. */
const light = ["#005f9e", "#b34700", "#00745a", "#a03a7c", "#6b5b00", "#2f2f2f"];
const dark = ["#6cb8f0", "#ff9d5c", "#3fd0a4", "#ef9bcb", "#e6d35c", "#dddddd"];

const dashes: readonly (readonly number[])[] = [[], [8, 4], [2, 3], [8, 3, 2, 3], [14, 4], [5, 2, 5, 6]];

export function lineColour(index: number, isDark: boolean): string {
  const colours = isDark ? dark : light;
  return colours[index % colours.length] ?? "#888888";
}

export function lineDash(index: number): number[] {
  // The first six lines differ in colour and dashes. Later lines repeat them in other combinations.
  return [...(dashes[(index + Math.floor(index / dashes.length)) % dashes.length] ?? [])];
}
