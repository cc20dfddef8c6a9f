// Draws overlaid histograms as SVG. A table below contains the same numbers as text.
import { el, svgEl } from "../ui/dom";
import { number } from "../ui/words";
import type { Chart } from "./line-chart";
import { legendOf } from "./line-chart";
import { lineColour, lineDash } from "./palette";
import type { PlotBars, PlotData } from "./series-data";

const width = 800;
const height = 320;
const left = 64;
const bottom = 44;
const top = 12;

export function makeBarChart(data: PlotData, isDark: boolean): Chart {
  const svg = svgEl("svg", {
    viewBox: `0 0 ${width} ${height}`,
    class: "bar-chart",
    role: "img",
    "aria-label": data.title,
  });
  const highest = Math.max(
    1e-300,
    ...data.bars.flatMap(({ height }) => Array.from(height)).filter(Number.isFinite),
  );
  const placeY = (value: number): number => height - bottom - ((height - bottom - top) * value) / highest;
  drawScale(svg, highest, placeY, data);
  drawHistograms(svg, data, isDark, placeY);
  return {
    element: el(
      "div",
      {},
      legendOf(data, isDark),
      svg,
      el("details", {}, el("summary", {}, "Show as table"), tableOf(data)),
    ),
    dispose: () => undefined,
  };
}

function drawScale(
  svg: SVGSVGElement,
  highest: number,
  placeY: (value: number) => number,
  data: PlotData,
): void {
  for (let i = 0; i <= 4; i++) {
    const value = (highest * i) / 4;
    const y = placeY(value);
    svg.append(
      svgEl("line", { x1: left, x2: width - 8, y1: y, y2: y, class: "grid-line" }),
      svgEl("text", { x: left - 6, y: y + 4, class: "tick tick-end" }, number(value)),
    );
  }
  svg.append(svgEl("text", { x: (left + width) / 2, y: height - 6, class: "tick tick-middle" }, data.xLabel));
}

function drawHistograms(
  svg: SVGSVGElement,
  data: PlotData,
  isDark: boolean,
  placeY: (value: number) => number,
): void {
  const edges = data.bars.flatMap((bar) => Array.from(bar.x)).filter(Number.isFinite);
  const low = Math.min(...edges);
  const high = Math.max(...edges);
  const placeX = (value: number): number =>
    left + ((width - left - 8) * (value - low)) / (high > low ? high - low : 1);
  data.bars.forEach((bar, k) => {
    const fill = k === data.bars.length - 1 ? lineColour(k, isDark) : "none";
    svg.append(
      svgEl("path", {
        d: outline(bar, placeX, placeY),
        fill,
        "fill-opacity": 0.18,
        stroke: lineColour(k, isDark),
        "stroke-width": 2,
        "stroke-dasharray": lineDash(k).join(" "),
      }),
    );
  });
  for (let i = 0; i <= 6; i++) {
    const value = low + ((high - low) * i) / 6;
    // At the picture's edge, the last label ends at its tick instead of being centred.
    const place = i < 6 ? "tick-middle" : "tick-end";
    const x = i < 6 ? placeX(value) : width;
    svg.append(svgEl("text", { x, y: height - bottom + 16, class: `tick ${place}` }, number(value)));
  }
}

function outline(
  bar: PlotBars,
  placeX: (value: number) => number,
  placeY: (value: number) => number,
): string {
  const parts = [`M${placeX(bar.x[0] ?? 0)} ${placeY(0)}`];
  bar.height.forEach((value, i) => {
    const y = placeY(Number.isFinite(value) ? value : 0);
    parts.push(`L${placeX(bar.x[i] ?? 0)} ${y}`, `L${placeX(bar.x[i + 1] ?? bar.x[i] ?? 0)} ${y}`);
  });
  parts.push(`L${placeX(bar.x[bar.height.length] ?? bar.x[bar.x.length - 1] ?? 0)} ${placeY(0)}`);
  return parts.join("");
}

function tableOf(data: PlotData): HTMLElement {
  const rowsMax = 500;
  const many = Math.min(rowsMax, Math.max(0, ...data.bars.map((bar) => bar.height.length)));
  const rows = Array.from({ length: many }, (_, i) =>
    el(
      "tr",
      {},
      el("th", { scope: "row" }, number(data.bars[0]?.x[i] ?? i)),
      ...data.bars.map((bar) => el("td", {}, number(bar.height[i] ?? NaN))),
    ),
  );
  return el(
    "table",
    {},
    el(
      "thead",
      {},
      el(
        "tr",
        {},
        el("th", { scope: "col" }, data.xLabel || "Name"),
        ...data.bars.map((bar) => el("th", { scope: "col" }, bar.label)),
      ),
    ),
    el("tbody", {}, ...rows),
  );
}
