// Draws lines along a chain with uPlot. At each zoom, long lines are thinned to the columns of pixels.
import uPlot from "uplot";
import { button, el } from "../ui/dom";
import { count, counted, number } from "../ui/words";
import { aligned } from "./aligned";
import { decimated, lowerBound } from "./decimate";
import { lineColour, lineDash } from "./palette";
import type { PlotData, PlotLine, PlotMark } from "./series-data";

export interface LineChartOptions {
  readonly isDark: boolean;
  /** Called on a click, with x and the nearest line. */
  readonly onPoint: ((x: number, line: PlotLine) => void) | null;
  /** Called with a range of x that was dragged while "drag to filter" is on. */
  readonly onRange: ((from: number, to: number) => void) | null;
}

export interface Chart {
  readonly element: HTMLElement;
  dispose(): void;
}

const height = 380;
const markLanePx = 9;
/** A press that moves less than this counts as a click. */
const clickPx = 4;

export function makeLineChart(data: PlotData, options: LineChartOptions): Chart {
  const place = el("div", {
    class: "chart",
    role: "img",
    tabindex: 0,
    "aria-label":
      `${data.title}: ${data.lines.length} lines over ${data.xLabel}. ` +
      "Arrow keys scroll, + and − zoom, 0 shows all.",
  });
  const whole = wholeRange(data.lines);
  let { from, to } = whole;
  let isFiltering = false;
  let plot: uPlot | null = null;

  const dataNow = (): uPlot.AlignedData => {
    const columns = Math.max(50, Math.round((plot?.bbox.width ?? 800) / devicePixelRatio));
    return aligned(data.lines.map((line) => decimated(line, from, to, columns))) as uPlot.AlignedData;
  };
  const show = (low: number, high: number): void => {
    const least = (whole.to - whole.from) * 1e-7;
    from = Math.max(whole.from, Math.min(low, high));
    to = Math.min(whole.to, Math.max(low, high));
    if (to - from < least) to = from + least;
    plot?.batch(() => {
      plot?.setData(dataNow(), false);
      plot?.setScale("x", { min: from, max: to });
    });
  };
  const zoom = (factor: number): void => {
    const middle = (from + to) / 2;
    const half = ((to - from) * factor) / 2;
    show(middle - half, middle + half);
  };
  const shift = (share: number): void => {
    const by = Math.min(Math.max((to - from) * share, whole.from - from), whole.to - to);
    show(from + by, to + by);
  };
  const selected = (u: uPlot): void => {
    const { left, width } = u.select;
    if (width < clickPx) return;
    const low = u.posToVal(left, "x");
    const high = u.posToVal(left + width, "x");
    u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    if (isFiltering) options.onRange?.(low, high);
    else show(low, high);
  };
  const make = (): void => {
    plot?.destroy();
    const width = Math.max(280, place.clientWidth);
    plot = new uPlot(
      {
        width,
        height,
        legend: { show: false },
        cursor: { drag: { x: true, y: false, setScale: false } },
        scales: { x: { time: false, min: from, max: to } },
        axes: [axisOf(data.xLabel, options.isDark), { ...axisOf(data.yLabel, options.isDark), size: 64 }],
        series: [
          {},
          ...data.lines.map((line, i) => ({
            stroke: lineColour(i, options.isDark),
            dash: lineDash(i),
            width: 1,
            points: { show: false },
            ...(line.isSteps && uPlot.paths.stepped ? { paths: uPlot.paths.stepped({ align: 1 }) } : {}),
          })),
        ],
        hooks: { setSelect: [selected], draw: [(u) => drawMarks(u, data.marks, options.isDark)] },
      },
      dataNow(),
      place,
    );
    plot.over.addEventListener("click", () => {
      if (plot !== null && plot.select.width < clickPx) clicked(plot, data.lines, options.onPoint);
    });
    show(from, to);
  };
  const sizes = new ResizeObserver(() => {
    const width = Math.max(280, place.clientWidth);
    if (plot === null) make();
    else if (plot.width !== width) {
      plot.setSize({ width, height });
      show(from, to);
    }
  });
  sizes.observe(place);
  place.addEventListener("keydown", (event) => {
    const acts: Readonly<Record<string, () => void>> = {
      ArrowLeft: () => shift(-0.2),
      ArrowRight: () => shift(0.2),
      "+": () => zoom(0.5),
      "=": () => zoom(0.5),
      "-": () => zoom(2),
      "0": () => show(whole.from, whole.to),
    };
    const act = event.ctrlKey || event.metaKey ? undefined : acts[event.key];
    if (act === undefined) return;
    event.preventDefault();
    act();
  });
  const filter = button(
    "Drag to filter",
    () => {
      isFiltering = !isFiltering;
      filter.setAttribute("aria-pressed", String(isFiltering));
    },
    { "aria-pressed": "false", class: "small", id: "plot-filter", hidden: options.onRange === null },
  );
  const shown = button("Filter by visible range", () => options.onRange?.(from, to), {
    class: "small",
    hidden: options.onRange === null,
    id: "plot-filter-seen",
  });
  return {
    element: el(
      "div",
      {},
      legendOf(data, options.isDark),
      place,
      el(
        "div",
        { class: "buttons" },
        button("Zoom in", () => zoom(0.5), { class: "small" }),
        button("Zoom out", () => zoom(2), { class: "small" }),
        button("All", () => show(whole.from, whole.to), { class: "small", id: "plot-all" }),
        filter,
        shown,
      ),
    ),
    dispose() {
      sizes.disconnect();
      plot?.destroy();
      plot = null;
    },
  };
}

function wholeRange(lines: readonly PlotLine[]): { from: number; to: number } {
  let from = Infinity;
  let to = -Infinity;
  for (const { x } of lines) {
    from = Math.min(from, x[0] ?? Infinity);
    to = Math.max(to, x[x.length - 1] ?? -Infinity);
  }
  return from <= to ? { from, to: to > from ? to : from + 1 } : { from: 0, to: 1 };
}

export function axisOf(label: string, isDark: boolean): uPlot.Axis {
  const text = isDark ? "#c9ced6" : "#3d434b";
  const line = isDark ? "#3a4048" : "#dcdfe3";
  return {
    label,
    stroke: text,
    grid: { stroke: line, width: 1 },
    ticks: { stroke: line },
    font: "12px system-ui",
    labelFont: "12px system-ui",
  };
}

/** Calls `onPoint` with the line whose value is nearest to the pointer. */
function clicked(u: uPlot, lines: readonly PlotLine[], onPoint: LineChartOptions["onPoint"]): void {
  const { left, top } = u.cursor;
  if (onPoint === null || left === undefined || top === undefined || left < 0) return;
  const at = u.posToVal(left, "x");
  let best: { line: PlotLine; x: number; away: number } | null = null;
  for (const line of lines) {
    const index = lowerBound(line.x, at);
    for (const near of [index - 1, index]) {
      const x = line.x[near];
      const y = line.y[near];
      if (x === undefined || y === undefined) continue;
      const away = Math.hypot(u.valToPos(x, "x") - left, u.valToPos(y, "y") - top);
      if (best === null || away < best.away) best = { line, x, away };
    }
  }
  if (best !== null) onPoint(best.x, best.line);
}

/** Draws ticks in lanes below the top edge, one lane per kind, at most one tick per pixel column. */
function drawMarks(u: uPlot, marks: readonly PlotMark[], isDark: boolean): void {
  const { ctx, bbox } = u;
  const lane = markLanePx * devicePixelRatio;
  ctx.save();
  ctx.setLineDash([]);
  ctx.lineWidth = devicePixelRatio;
  marks.forEach((mark, i) => {
    ctx.strokeStyle = markColour(isDark);
    const top = bbox.top + i * lane;
    let before = -1;
    ctx.beginPath();
    for (let k = lowerBound(mark.x, u.posToVal(0, "x")); k < mark.x.length; k++) {
      const place = Math.round(u.valToPos(mark.x[k] ?? NaN, "x", true));
      if (place > bbox.left + bbox.width) break;
      if (place === before) continue;
      before = place;
      tick(ctx, i, place, top, lane);
    }
    ctx.stroke();
  });
  ctx.restore();
}

/** Kinds differ in shape: a bar, a wedge that points down, a circle. */
function tick(ctx: CanvasRenderingContext2D, kind: number, x: number, top: number, lane: number): void {
  const reach = lane / 3;
  if (kind % 3 === 0) {
    ctx.moveTo(x, top + 1);
    ctx.lineTo(x, top + lane - 1);
  } else if (kind % 3 === 1) {
    ctx.moveTo(x - reach, top + 2);
    ctx.lineTo(x, top + lane - 2);
    ctx.lineTo(x + reach, top + 2);
  } else {
    ctx.moveTo(x + reach, top + lane / 2);
    ctx.arc(x, top + lane / 2, reach, 0, 2 * Math.PI);
  }
}

function markColour(isDark: boolean): string {
  return isDark ? "#d5dae0" : "#3d434b";
}

export function legendOf(data: PlotData, isDark: boolean): HTMLElement {
  const picture = (draw: (context: CanvasRenderingContext2D) => void): HTMLCanvasElement => {
    const canvas = el("canvas", { class: "swatch", width: 64, height: 24, "aria-hidden": "true" });
    const context = canvas.getContext("2d");
    if (context !== null) draw(context);
    context?.stroke();
    return canvas;
  };
  const swatch = (index: number): HTMLCanvasElement =>
    picture((context) => {
      context.strokeStyle = lineColour(index, isDark);
      context.setLineDash(lineDash(index).map((dash) => 2 * dash));
      context.lineWidth = 4;
      context.moveTo(0, 12);
      context.lineTo(64, 12);
    });
  const markSwatch = (index: number): HTMLCanvasElement =>
    picture((context) => {
      context.strokeStyle = markColour(isDark);
      context.lineWidth = 3;
      tick(context, index, 44, 0, 24);
    });
  const lines = data.lines.map((line, i) => {
    const last = line.y[line.y.length - 1];
    return el(
      "li",
      {},
      swatch(i),
      `${line.label} (${counted(line.x.length, "point", "points")}, last ${number(last ?? NaN)})`,
    );
  });
  const marks = data.marks.map((mark, i) =>
    el("li", {}, markSwatch(i), `${mark.label} (${count(mark.x.length)})`),
  );
  const bars =
    data.kind === "histograms" ? data.bars.map((bar, i) => el("li", {}, swatch(i), bar.label)) : [];
  return el("ul", { class: "legend" }, ...lines, ...bars, ...marks);
}
