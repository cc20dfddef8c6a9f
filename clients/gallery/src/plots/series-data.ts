// Converts a plot's answer into chart data. Missing or unknown parts are skipped, so that an older page shows
// the known parts of a newer server's plots. clients/gallery_server/series.h describes kinds and columns.
import type { Column, Series } from "../data/types";

export interface PlotLine {
  readonly label: string;
  /** -1: the line belongs to no chain. */
  readonly chain: number;
  readonly x: Column;
  readonly y: Column;
  /** Each value holds until the next one. */
  readonly isSteps: boolean;
}

export interface PlotMark {
  readonly label: string;
  readonly x: Column;
}

export interface PlotBars {
  readonly label: string;
  /** Edges of bars: one more than heights. */
  readonly x: Column;
  readonly height: Column;
}

export interface PlotData {
  readonly title: string;
  readonly kind: "lines" | "histograms";
  readonly notices: readonly string[];
  readonly xLabel: string;
  readonly yLabel: string;
  /** Meaning of x. Only for "draw" do points have animations, and ranges queries. */
  readonly xIs: "draw" | "other";
  readonly lines: readonly PlotLine[];
  readonly marks: readonly PlotMark[];
  readonly bars: readonly PlotBars[];
}

type Fields = Readonly<Record<string, unknown>>;

const nothing: PlotData = {
  title: "",
  kind: "lines",
  notices: [],
  xLabel: "",
  yLabel: "",
  xIs: "other",
  lines: [],
  marks: [],
  bars: [],
};

/** `all`: a trace has an answer for each chain; other plots have one answer. */
export function plotDataOf(title: string, kind: string, all: readonly Series[]): PlotData {
  const first = all[0];
  if (first === undefined) return { ...nothing, title };
  if (kind === "trace") return traceOf(title, all);
  if (kind === "pair") return pairOf(title, first);
  if (kind === "levels") return levelsOf(title, first);
  if (kind === "index") return indexOf(title, first);
  return roundsOf(title, first);
}

function traceOf(title: string, all: readonly Series[]): PlotData {
  const heads = all.map((series) => fieldsOf(series.head));
  const lines = all.flatMap(({ columns }, i) => {
    const x = columns.get("draw");
    const y = columns.get("value");
    const chain = numberOf(heads[i]?.["chain"]) ?? i;
    return x && y ? [{ label: `chain ${chain}`, chain, x, y, isSteps: false }] : [];
  });
  const kinds = [
    { name: "change_all", label: "accepted change-all proposal" },
    { name: "fall", label: "chain stops satisfying" },
    { name: "lineage", label: "new lineage" },
  ];
  const marks = kinds.flatMap(({ name, label }) => {
    const x = merged(all.flatMap(({ columns }) => columns.get(name) ?? []));
    return x.length === 0 ? [] : [{ label, x }];
  });
  const isThinned = heads.some((head) => head["is_thinned"] === true);
  const notices = isThinned
    ? ["This trace is thinned: it shows extremes, but omits other draws between the points."]
    : [];
  const unit = textOf(heads[0]?.["unit"]);
  return {
    ...nothing,
    title,
    notices,
    lines,
    marks,
    xLabel: "draw",
    xIs: "draw",
    yLabel: unit === "1" ? "" : unit,
  };
}

/** Merges the chains' columns in ascending order. */
function merged(columns: readonly Column[]): Float64Array {
  return Float64Array.from(columns.flatMap((column) => Array.from(column))).sort();
}

function pairOf(title: string, { head, columns }: Series): PlotData {
  const fields = fieldsOf(head);
  const x = columns.get("edges");
  const parts = [
    { name: "prior", label: "prior" },
    { name: "posterior", label: "posterior" },
  ];
  const bars = parts.flatMap(({ name, label }) => {
    const height = columns.get(name);
    return x && height ? [{ label, x, height }] : [];
  });
  const weighted = "Draws are weighted; the histogram uses the weights.";
  const notices = fields["is_weighted"] === true ? [weighted] : [];
  const unit = textOf(fields["unit"]);
  return {
    ...nothing,
    title,
    kind: "histograms",
    notices,
    bars,
    xLabel: unit === "1" ? "" : unit,
  };
}

/** The ladder's last round, by level. */
function levelsOf(title: string, { head, columns }: Series): PlotData {
  const fields = fieldsOf(head);
  const rounds = columns.get("round");
  const levels = columns.get("level");
  if (!rounds || !levels) return { ...nothing, title };
  const ofRows = Array.from(rounds);
  const last = ofRows.reduce((most, round) => Math.max(most, round), 0);
  const rows = [...ofRows.keys()].filter((row) => ofRows[row] === last);
  const kinds = stringsOf(fields["kinds"]);
  const parts = [
    { name: "inverse_temperature", label: "inverse temperature" },
    { name: "swap_acceptance", label: "accepted swaps with the next cooler level" },
    ...kinds.map((kind, i) => ({ name: `acceptance.${i}`, label: `accepted proposals: ${kind}` })),
  ];
  const x = Float64Array.from(rows, (row) => levels[row] ?? NaN);
  const lines = parts.flatMap(({ name, label }) => {
    const column = columns.get(name);
    return column
      ? [{ label, chain: -1, x, y: Float64Array.from(rows, (row) => column[row] ?? NaN), isSteps: false }]
      : [];
  });
  const xLabel = `level (0: the prior), after round ${last + 1}`;
  return { ...nothing, title, lines, xLabel };
}

function roundsOf(title: string, { columns }: Series): PlotData {
  const x = columns.get("round");
  if (!x) return { ...nothing, title };
  const names = ["round_trips", "predicted_round_trips", "restarts", "barrier"];
  const lines = names.flatMap((name) => {
    const y = columns.get(name);
    return y ? [{ label: name.replaceAll("_", " "), chain: -1, x, y, isSteps: true }] : [];
  });
  return { ...nothing, title, lines, xLabel: "round" };
}

/** One line per replica. Replicas that travel all the way up and down bring new draws. */
function indexOf(title: string, { head, columns }: Series): PlotData {
  const fields = fieldsOf(head);
  const x = columns.get("scan");
  if (!x) return { ...nothing, title };
  const replicas = numberOf(fields["replicas"]) ?? 0;
  const lines = Array.from({ length: replicas }, (_, replica) => replica).flatMap((replica) => {
    const levels = columns.get(`level.${replica}`) ?? [];
    // Some replicas exist only for a part of the run.
    const there = [...levels.keys()].filter((moment) => Number.isFinite(levels[moment]));
    const ofThere = (column: Column | readonly number[]): Float64Array =>
      Float64Array.from(there, (moment) => column[moment] ?? NaN);
    const line = { label: `replica ${replica}`, chain: -1, x: ofThere(x), y: ofThere(levels), isSteps: true };
    return there.length > 0 ? [line] : [];
  });
  const begins = columns.get("round");
  const marks = begins ? [{ label: "start of a round, with new temperatures", x: begins }] : [];
  const every = (x[1] ?? 0) - (x[0] ?? 0);
  const notices = every > 1 ? [`Only one scan in ${every} was recorded; replicas may have moved in between.`] : [];
  return { ...nothing, title, notices, lines, marks, xLabel: "scan", yLabel: "level (0: the prior)" };
}

/** Number of chains of a trace, from one chain's answer. */
export function chainsOf(series: Series): number {
  return Math.max(1, numberOf(fieldsOf(series.head)["chains"]) ?? 1);
}

function fieldsOf(value: unknown): Fields {
  return typeof value === "object" && value !== null ? (value as Fields) : {};
}

function stringsOf(value: unknown): string[] {
  return Array.isArray(value) ? value.filter((part) => typeof part === "string") : [];
}

function textOf(value: unknown): string {
  return typeof value === "string" ? value : "";
}

function numberOf(value: unknown): number | null {
  return typeof value === "number" && Number.isFinite(value) ? value : null;
}
