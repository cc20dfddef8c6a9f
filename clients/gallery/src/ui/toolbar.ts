// The toolbar above the wall: open groups, view, grouping and sorting.
import type { AppState } from "../state/app-state";
import { actedOn, within } from "../state/derived";
import { groupsMax, groupsMin, type GroupsBy, type View } from "../state/page";
import { sortFromText, sortToText } from "../state/sorting";
import { button, el, field, select, setAttribute, setChoices, setHidden, setText } from "./dom";
import type { Part, Ui } from "./part";
import { count, counted, named } from "./words";

const views: readonly { view: View; label: string }[] = [
  { view: "groups", label: "Groups" },
  { view: "list", label: "List" },
  { view: "plots", label: "Plots" },
];

export function makeToolbar(ui: Ui, focusedName: () => string | null): Part {
  const crumbs = el("ol", { class: "crumbs-list" });
  const tabs = views.map(({ view, label }) =>
    button(label, () => ui.page.showView(view), {
      class: "tab",
      id: `view-${view}`,
      "aria-pressed": "false",
    }),
  );
  const groups = el("input", {
    type: "number",
    id: "groups-count",
    min: groupsMin,
    max: groupsMax,
    step: 1,
    on: {
      change: () => {
        const { grouping } = ui.store.state.page;
        const asked = groups.value === "" ? grouping.groups : Math.round(groups.valueAsNumber);
        const clamped = Math.min(groupsMax, Math.max(groupsMin, asked));
        groups.value = String(clamped);
        ui.page.change({ grouping: { ...grouping, groups: clamped } });
      },
    },
  });
  const by = select(
    [
      { value: "medoids", label: "by medoids" },
      { value: "hierarchy", label: "by hierarchy" },
    ],
    "medoids",
    (value) => ui.page.change({ grouping: { ...ui.store.state.page.grouping, by: value as GroupsBy } }),
    {
      id: "groups-by",
      "aria-label": "Grouping method",
      title:
        "Medoids: the best groups for this number of groups. " +
        "Hierarchy: nested groups; if you lower the number, groups merge.",
    },
  );
  const groupTools = el("div", { class: "tool-group" }, field("Groups", groups), by);
  const sort = select(
    [],
    "",
    (value) => {
      if (value === "like") {
        ui.page.sortByLikeness(actedOn(ui.store.state, focusedName()), false);
        // Without a selection the order doesn't change.
        sort.value = sortValue(ui.store.state);
      } else ui.page.change({ sort: sortFromText(value) });
    },
    { id: "sort" },
  );
  const turn = button(
    "",
    () => {
      const now = ui.store.state.page.sort;
      if (now.by === "number") ui.page.change({ sort: { ...now, isDescending: !now.isDescending } });
      if (now.by === "alike") ui.page.change({ sort: { ...now, isUnlike: !now.isUnlike } });
    },
    { id: "sort-turn", class: "small" },
  );
  const listTools = el("div", { class: "tool-group" }, field("Sort by", sort), turn);
  const moving = button("Moving", () => ui.theme.moveCards(ui.theme.areCardsStill), {
    id: "cards-moving",
    class: "small",
    title: "Animate cards, or show how animations end (e)",
  });
  const showMoving = (): void => setAttribute(moving, "aria-pressed", String(!ui.theme.areCardsStill));
  ui.theme.onChange(showMoving);
  showMoving();
  const words = el("p", { class: "hint toolbar-words", id: "toolbar-words" });

  const update = (state: AppState, before: AppState): void => {
    const { page, loaded } = state;
    views.forEach(({ view }, i) =>
      setAttribute(tabs[i] ?? crumbs, "aria-pressed", String(view === page.view)),
    );
    setHidden(groupTools, page.view !== "groups");
    setHidden(listTools, page.view !== "list");
    setHidden(moving, page.view === "plots");
    if (document.activeElement !== groups) groups.value = String(page.grouping.groups);
    by.value = page.grouping.by;
    if (state === before || page.path !== before.page.path || state.opened !== before.opened)
      crumbs.replaceChildren(...crumbItems(ui, state));
    if (state === before || page.sort !== before.page.sort || loaded !== before.loaded)
      setChoices(sort, sortChoices(state), sortValue(state));
    setHidden(turn, page.sort.by === "kept");
    const isDown =
      page.sort.by === "number" ? page.sort.isDescending : page.sort.by === "alike" && page.sort.isUnlike;
    setText(turn, isDown ? "↓ largest first" : "↑ smallest first");
    setText(words, toolbarWords(state));
  };
  return {
    element: el(
      "div",
      { class: "toolbar" },
      el("nav", { "aria-label": "Breadcrumbs", class: "crumbs" }, crumbs),
      el("div", { class: "tool-group", role: "group", "aria-label": "View" }, ...tabs),
      groupTools,
      listTools,
      moving,
      words,
    ),
    update,
  };
}

function crumbItems(ui: Ui, state: AppState): HTMLElement[] {
  const { path } = state.page;
  const item = (label: string, depth: number): HTMLElement =>
    el(
      "li",
      {},
      depth === path.length
        ? el("span", { "aria-current": "location" }, label)
        : button(label, () => ui.page.closeTo(depth), { class: "link" }),
    );
  return [
    item("All", 0),
    ...path.map((step, i) => {
      const many = state.opened[i]?.length;
      return item(`like ${step.representative}${many === undefined ? "" : ` (${count(many)})`}`, i + 1);
    }),
  ];
}

function sortChoices(state: AppState) {
  const { sort } = state.page;
  const numbers = state.loaded?.scene.numbers ?? [];
  const choices = [
    { value: "", label: "archive order" },
    { value: "like", label: "likeness to the selection" },
    ...numbers.map(({ name, unit }) => ({ value: `-${name}`, label: words(name, unit) })),
  ];
  if (sort.by === "alike")
    choices.push({ value: sortToText(sort), label: `likeness to ${shortList(sort.to)}` });
  return choices;
}

function words(name: string, unit: string): string {
  if (name === "log_prior") return "plausibility (log_prior)";
  if (name === "log_constraint") return "score (log_constraint)";
  return named(name, unit);
}

function sortValue(state: AppState): string {
  const { sort } = state.page;
  return sort.by === "number" ? `-${sort.number}` : sortToText(sort);
}

function shortList(names: readonly string[]): string {
  return names.length <= 2 ? names.join(", ") : `${names[0] ?? ""} and ${names.length - 1} more`;
}

function toolbarWords(state: AppState): string {
  const { page, groups } = state;
  if (page.view === "list") {
    if (page.sort.by === "alike")
      return `${page.sort.isUnlike ? "Least" : "Most"} similar to ${shortList(page.sort.to)} first.`;
    return "";
  }
  if (page.view !== "groups") return "";
  if (state.groupsFailure !== "") return state.groupsFailure;
  if (groups === null) return state.loaded === null ? "" : "Grouping …";
  const many = counted(groups.list.length, "group", "groups");
  const few =
    groups.list.length < page.grouping.groups && groups.of.length > 0 ? "; no more are possible" : "";
  const approximate = groups.isApproximate
    ? " Groups are based on a sample of 200 animations. Each other animation joins the nearest group."
    : "";
  const shares = groups.shareWords === "" ? "" : ` ${groups.shareWords}`;
  return `${many} of similar animations (${count(within(state).length)} in all${few}).${approximate}${shares}`;
}
