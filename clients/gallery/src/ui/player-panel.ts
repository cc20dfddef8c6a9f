// The player as a part of the page. The player follows page.playing; a person's changes in the player (time,
// camera, drawn box or time range) go into the page's state.
import { SourceError } from "../data/source";
import type { Animation } from "../data/types";
import type { AppState } from "../state/app-state";
import { linkOf } from "../state/link";
import { linkPage } from "../state/address";
import { say, sentenceOf } from "../state/messages";
import { Latest } from "../state/store";
import { Pose } from "../motion/pose";
import type { CameraState } from "../view/camera";
import { CELLS_MAX } from "../view/cells";
import { Player, type PlayerEvent } from "../view/player";
import type { SharedRenderer } from "../view/renderer";
import type { ArchiveStage } from "../view/stage";
import { copyText } from "./copying";
import { makeDetails } from "./details";
import { el, iconButton, setHidden, setText } from "./dom";
import { makeExportHint } from "./export-hint";
import type { Part, Ui } from "./part";
import { makeControls } from "./player-controls";
import { Timeline } from "./timeline";
import { millimetres, noPictures } from "./words";

export interface PlayerPanel extends Part {
  readonly player: Player;
  toggleTrails(): void;
  focus(): void;
}

const putDelayMs = 250;

export function makePlayerPanel(
  ui: Ui,
  renderer: SharedRenderer,
  stageOf: () => ArchiveStage | null,
  onPlaying: (isPlaying: boolean) => void,
): PlayerPanel {
  const canvas = el("canvas", {
    class: "player-canvas",
    id: "player-canvas",
    tabindex: 0,
    role: "img",
    "aria-label": "Animations in 3D. Drag to turn the camera; scroll to zoom. The buttons below do the same.",
  });
  const labels = el("div", { class: "player-labels", "aria-hidden": "true" });
  const player = new Player(canvas, renderer, ui.theme.shade);
  const animations = new Map<string, Animation>();
  const latest = new Latest();
  let abort = new AbortController();
  let shown: readonly string[] = [];
  let putCamera: CameraState | null = null;
  let putTimeS: number | null = null;
  /** The player doesn't show the state's animations yet. */
  let isLoading = false;
  let timer: ReturnType<typeof setTimeout> | undefined;

  const copyLink = (): void => {
    put();
    const link = `${location.href.split("#")[0] ?? ""}#${linkOf(linkPage(ui.store.state))}`;
    void copyText(ui.store, link, "Link");
  };
  const controls = makeControls({ player, onSync: (sync) => ui.page.change({ sync }), onCopyLink: copyLink });
  const timeline = new Timeline({
    onSeek: (time) => player.seek(time),
    onStep: (frames) => player.step(frames),
    onRange: (from, to) => {
      // Queries use the animation's own time, without the player's shift.
      const shift = player.timeline().items[details.chosen]?.shiftS ?? 0;
      const own = (time: number): number => Math.round((time + shift) * 1000) / 1000;
      ui.store.set({ drawnRange: { low: own(from), high: own(to) } });
    },
  });
  const details = makeDetails(ui, (time) => player.seek(time));
  const exportHint = makeExportHint(ui, (state) => state.page.playing, "export-playing");
  const title = el("h2", { id: "player-title" }, "Player");
  const close = iconButton("close", "Close the player (Escape)", () => ui.page.closePlayer(), {
    id: "close-player",
  });
  const hint = el("p", { class: "player-hint", id: "player-hint" });
  const failure = el("p", { class: "trouble", id: "player-failure", hidden: true });
  const element = el(
    "section",
    { class: "player", id: "player", "aria-labelledby": "player-title", hidden: true },
    el("div", { class: "player-head" }, title, close),
    failure,
    el("div", { class: "player-view" }, canvas, labels),
    hint,
    controls.transport,
    timeline.element,
    controls.more,
    details.element,
    exportHint.element,
  );

  // Stores time and camera in the link once they stop changing.
  const put = (): void => {
    clearTimeout(timer);
    if (isLoading || ui.store.state.page.playing.length === 0) return;
    putTimeS = player.isPlaying ? ui.store.state.page.timeS : player.time;
    ui.page.change({ timeS: putTimeS, camera: putCamera ?? ui.store.state.page.camera });
  };
  const putLater = (): void => {
    clearTimeout(timer);
    timer = setTimeout(put, putDelayMs);
  };
  player.onEvent = (event: PlayerEvent): void => {
    if (event.kind === "time") {
      timeline.setTime(event.time);
      controls.showTime(event.time);
      if (!isLoading && !player.isPlaying && event.time !== putTimeS) putLater();
    } else if (event.kind === "playing") {
      controls.showPlaying(event.isPlaying);
      onPlaying(event.isPlaying);
      if (!event.isPlaying) putLater();
    } else if (event.kind === "camera") {
      putCamera = event.camera;
      putLater();
    } else if (event.kind === "box") {
      ui.store.set({ drawnBox: event.box });
    } else if (event.kind === "pick") {
      setText(hint, event.picked === null ? "" : placeWords(event.picked));
    } else placeLabels();
  };
  const pose = new Pose();
  const placeWords = ({ index, feature, name }: { index: number; feature: number; name: string }): string => {
    const { loaded, page } = ui.store.state;
    const recording = animations.get(page.playing[index] ?? "")?.recording;
    if (loaded === null || recording === undefined || feature >= loaded.bodies) return name;
    if (!recording.centreAt(feature, player.ownTime(index), pose)) return name;
    return `${name} at x ${millimetres(pose.x)}, y ${millimetres(pose.y)}, z ${millimetres(pose.z)}`;
  };
  const placeLabels = (): void => {
    const cells = player.cells();
    const isMany = shown.length > 1;
    labels.replaceChildren(
      ...(isMany
        ? cells.map((cell, i) => {
            const label = el("span", { class: "player-label" }, shown[i] ?? "");
            label.style.left = `${cell.x}px`;
            label.style.top = `${cell.y}px`;
            label.style.maxWidth = `${cell.width}px`;
            return label;
          })
        : []),
    );
  };

  const load = async (state: AppState): Promise<void> => {
    const { loaded, page } = state;
    const stage = stageOf();
    const isWanted = latest.begin();
    abort.abort();
    abort = new AbortController();
    isLoading = true;
    clearTimeout(timer);
    if (loaded === null || stage === null) return;
    const known = page.playing.filter((name) => loaded.entryOf.has(name));
    const missing = known.slice(0, CELLS_MAX).filter((name) => !animations.has(name));
    try {
      if (missing.length > 0) {
        const got = await ui.source.animations(loaded.id, missing, loaded.bodies, { signal: abort.signal });
        if (!isWanted()) return;
        for (const animation of got) animations.set(animation.name, animation);
      }
      for (const name of animations.keys()) if (!known.includes(name)) animations.delete(name);
      const lost = page.playing.filter((name) => !loaded.entryOf.has(name));
      setText(failure, lost.length === 0 ? "" : `Not in this archive: ${lost.join(", ")}.`);
      setHidden(failure, lost.length === 0);
      show(known, stage);
    } catch (error) {
      if (!isWanted() || (error instanceof SourceError && error.kind === "aborted")) return;
      setText(failure, sentenceOf(error));
      setHidden(failure, false);
      say(ui.store, sentenceOf(error));
    }
  };
  const show = (names: readonly string[], stage: ArchiveStage): void => {
    const { page } = ui.store.state;
    isLoading = false;
    shown = names;
    player.setAnimations(
      names.flatMap((name) => {
        const animation = animations.get(name);
        return animation === undefined ? [] : [{ stage, animation, label: name }];
      }),
    );
    player.setSync(page.sync);
    if (page.camera !== null) player.setCamera(page.camera);
    showTimeline();
    controls.showItems(names, page.sync);
    placeLabels();
    if (page.timeS !== null) player.seek(page.timeS);
    else {
      player.seek(player.range.from);
      if (!ui.theme.isStill) player.play();
    }
  };
  const showTimeline = (): void => {
    const data = player.timeline();
    timeline.show({ ...data, ...player.range });
    details.show(data.items);
    controls.showTime(player.time);
  };
  ui.theme.onChange(() => {
    player.setTheme(ui.theme.shade);
    timeline.draw();
  });

  const update = (state: AppState, before: AppState): void => {
    const { page } = state;
    const isOpen = page.playing.length > 0;
    setHidden(element, !isOpen);
    setText(
      title,
      page.playing.length === 1
        ? `Player: ${page.playing[0] ?? ""}`
        : `Player: ${page.playing.length} animations`,
    );
    const isOther =
      page.playing !== before.page.playing ||
      state.loaded?.looks !== before.loaded?.looks ||
      state === before;
    if (isOther && isOpen) {
      if (state.loaded?.run !== before.loaded?.run) animations.clear();
      void load(state);
    } else if (isOther) {
      latest.drop();
      player.pause();
      player.setAnimations([]);
      shown = [];
      putCamera = null;
    } else if (isOpen) follow(state, before);
    followDrawing(state, before);
    details.update(state, before);
    exportHint.update(state, before);
    if (isOpen && !renderer.available) {
      setText(failure, noPictures);
      setHidden(failure, false);
    }
  };
  /** Links, the browser's "back" and the alignment field change the player's state from outside. */
  const follow = (state: AppState, before: AppState): void => {
    const { page } = state;
    if (page.sync !== before.page.sync) {
      player.setSync(page.sync);
      controls.showItems(shown, page.sync);
      showTimeline();
    }
    if (page.camera !== before.page.camera && page.camera !== null && page.camera !== putCamera)
      player.setCamera(page.camera);
    if (page.timeS !== before.page.timeS && page.timeS !== null && page.timeS !== putTimeS)
      player.seek(page.timeS);
  };
  const followDrawing = (state: AppState, before: AppState): void => {
    const { drawing, drawnBox } = state;
    if (drawing !== before.drawing) {
      timeline.setMarking(drawing.time);
      if (drawing.box && drawnBox === null) player.startBox();
      if (!drawing.box && before.drawing.box) player.endBox();
      setText(
        hint,
        drawing.box
          ? "Drag in the picture to draw a box, then pull its faces; or type numbers in the form."
          : drawing.time
            ? "Drag along the timeline to mark a time range."
            : "",
      );
    }
    if (
      drawing.box &&
      drawnBox !== before.drawnBox &&
      JSON.stringify(drawnBox) !== JSON.stringify(player.box)
    )
      player.setBox(drawnBox);
  };
  return { element, update, player, toggleTrails: controls.toggleTrails, focus: () => canvas.focus() };
}
