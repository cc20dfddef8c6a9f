// The player's buttons: time, speed, synchronization, what is drawn, and the camera.
import type { SyncMode } from "../motion/sync";
import type { Player } from "../view/player";
import { button, el, field, iconButton, iconOf, select, setChoices, setHidden, setText } from "./dom";
import { seconds } from "./words";

export interface ControlsOptions {
  readonly player: Player;
  readonly onSync: (sync: SyncMode) => void;
  readonly onCopyLink: () => void;
}

export interface Controls {
  readonly transport: HTMLElement;
  readonly more: HTMLElement;
  showPlaying(isPlaying: boolean): void;
  showTime(time: number): void;
  /** Updates the names of the playing animations, and their synchronization. */
  showItems(names: readonly string[], sync: SyncMode): void;
  toggleTrails(): void;
}

const speeds = [1 / 16, 1 / 8, 1 / 4, 1 / 2, 1, 2, 4];

export function makeControls({ player, onSync, onCopyLink }: ControlsOptions): Controls {
  const play = iconButton("play", "Play", () => player.toggle(), { id: "play-pause", class: "primary" });
  const time = el("output", { class: "time", id: "time", for: "timeline" });
  const speed = select(
    speeds.map((value) => ({ value: String(value), label: value < 1 ? `1/${1 / value}` : `${value}×` })),
    "1",
    (value) => player.setSpeed(Number(value)),
    { id: "speed" },
  );
  const sync = select(
    [
      { value: "start", label: "at the start" },
      { value: "contact", label: "at the first contact" },
      { value: "end", label: "at the end" },
    ],
    "start",
    (value) => onSync(value as SyncMode),
    { id: "sync" },
  );
  const syncField = field("Align", sync);
  const ghost = select([], "", (value) => player.setGhost(value === "" ? null : Number(value)), {
    id: "ghost",
  });
  const ghostField = field("Ghost", ghost);
  const trails = checkbox("trails", "Trails", false, (on) => player.setTrails(on));
  const marks = checkbox("marks", "Hits", true, (on) => player.setMarks(on));
  const loop = checkbox("loop", "Loop", false, (on) => player.setLoop(on));
  const preset = (name: "home" | "front" | "top" | "side", label: string): HTMLElement =>
    button(label, () => player.preset(name), { class: "small", id: `camera-${name}` });
  player.setLoop(false);
  const turn = 0.2;
  return {
    transport: el(
      "div",
      { class: "transport", role: "group", "aria-label": "Playback" },
      iconButton("eventBack", "Previous event ([)", () => player.toEvent(-1), { id: "event-before" }),
      iconButton("frameBack", "Previous frame (,)", () => player.step(-1), { id: "frame-back" }),
      play,
      iconButton("frameOn", "Next frame (.)", () => player.step(1), { id: "frame-on" }),
      iconButton("eventOn", "Next event (])", () => player.toEvent(1), { id: "event-next" }),
      time,
      field("Speed", speed),
      syncField,
    ),
    more: el(
      "div",
      { class: "player-more" },
      el(
        "div",
        { class: "checks", role: "group", "aria-label": "Show" },
        trails,
        marks,
        loop,
        ghostField,
      ),
      el(
        "div",
        { class: "buttons", role: "group", "aria-label": "Camera" },
        preset("home", "Home"),
        preset("front", "Front"),
        preset("top", "Top"),
        preset("side", "Side"),
        button("◀", () => player.orbit(-turn, 0), { class: "small", "aria-label": "Turn left" }),
        button("▶", () => player.orbit(turn, 0), { class: "small", "aria-label": "Turn right" }),
        button("▲", () => player.orbit(0, turn), { class: "small", "aria-label": "Turn up" }),
        button("▼", () => player.orbit(0, -turn), { class: "small", "aria-label": "Turn down" }),
        button("+", () => player.zoom(1.25), { class: "small", "aria-label": "Zoom in" }),
        button("−", () => player.zoom(0.8), { class: "small", "aria-label": "Zoom out" }),
      ),
      button("Copy link", onCopyLink, { class: "small", id: "copy-link" }),
    ),
    showPlaying(isPlaying) {
      const label = isPlaying ? "Pause (k)" : "Play (k)";
      play.setAttribute("aria-label", label);
      play.title = label;
      play.replaceChildren(iconOf(isPlaying ? "pause" : "play"));
    },
    showTime(now) {
      setText(time, `${seconds(now)} of ${seconds(player.range.to)}`);
    },
    showItems(names, mode) {
      setHidden(syncField, names.length < 2);
      setHidden(ghostField, names.length < 2);
      sync.value = mode;
      const chosen = player.ghost === null ? "" : String(player.ghost);
      setChoices(
        ghost,
        [{ value: "", label: "none" }, ...names.map((label, i) => ({ value: String(i), label }))],
        chosen,
      );
    },
    toggleTrails() {
      const input = trails.querySelector("input");
      input?.click();
    },
  };
}

function checkbox(id: string, label: string, isOn: boolean, onChange: (on: boolean) => void): HTMLElement {
  const input = el("input", { type: "checkbox", id, on: { change: () => onChange(input.checked) } });
  input.checked = isOn;
  return el("div", { class: "check" }, input, el("label", { for: id }, label));
}
