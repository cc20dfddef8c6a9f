// Draws bar charts and overlaid histograms as SVG. A table below contains the same numbers as text.
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
    ...data.bars.flatMap((bar) =>
      Array.from(bar.height, (value, i) => value + (bar.error?.[i] ?? 0)).filter(Number.isFinite),
    ),
  );
  const placeY = (value: number): number => height - bottom - ((height - bottom - top) * value) / highest;
  drawScale(svg, highest, placeY, data);
  if (data.kind === "histograms") drawHistograms(svg, data, isDark, placeY);
  else drawBars(svg, data, isDark, placeY);
  return {
    element: el(
      "div",
      {},
      data.kind === "histograms" ? legendOf(data, isDark) : "",
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

function drawBars(
  svg: SVGSVGElement,
  data: PlotData,
  isDark: boolean,
  placeY: (value: number) => number,
): void {
  const many = Math.max(1, ...data.bars.map((bar) => bar.height.length));
  const slot = (width - left - 8) / many;
  const thick = (0.8 * slot) / Math.max(1, data.bars.length);
  const labelStep = Math.max(1, Math.ceil(many / 12));
  data.bars.forEach((bar, k) => {
    bar.height.forEach((value, i) => {
      if (!Number.isFinite(value)) return;
      const x = left + slot * (i + 0.1) + thick * k;
      const y = placeY(Math.max(0, value));
      const label = `${data.names[i] ?? number(bar.x[i] ?? i)}, ${bar.label}: ${number(value)}`;
      svg.append(
        svgEl(
          "rect",
          {
            x,
            y,
            width: Math.max(1, thick - 1),
            height: Math.max(0, placeY(0) - y),
            fill: lineColour(k, isDark),
          },
          svgEl("title", {}, label),
        ),
      );
      const error = bar.error?.[i] ?? NaN;
      if (Number.isFinite(error)) {
        const middle = x + thick / 2;
        svg.append(
          svgEl("line", {
            x1: middle,
            x2: middle,
            y1: placeY(Math.max(0, value - error)),
            y2: placeY(value + error),
            class: "error-bar",
          }),
        );
      }
    });
  });
  for (let i = 0; i < many; i += labelStep) {
    const label = data.names[i] ?? number(data.bars[0]?.x[i] ?? i);
    svg.append(
      svgEl(
        "text",
        { x: left + slot * (i + 0.5), y: height - bottom + 16, class: "tick tick-middle" },
        label,
      ),
    );
  }
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
      el("th", { scope: "row" }, data.names[i] ?? number(data.bars[0]?.x[i] ?? i)),
      ...data.bars.map((bar) => {
        const error = bar.error?.[i];
        const words = number(bar.height[i] ?? NaN);
        return el(
          "td",
          {},
          error === undefined || !Number.isFinite(error) ? words : `${words} ± ${number(error)}`,
        );
      }),
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
        ...data.bars.map((bar) => el("th", { scope: "col" }, bar.label || data.yLabel || "Value")),
      ),
    ),
    el("tbody", {}, ...rows),
  );
}
