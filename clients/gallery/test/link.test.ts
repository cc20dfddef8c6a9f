// Goal: links contain the page's whole state, and invalid links still open. Method: convert pages to links
// and back, with every part set and with special characters in names and queries. Open links damaged by hand.
import assert from "node:assert/strict";
import { test } from "node:test";
import { linkOf, pageOf, placeOf } from "../src/state/link";
import { firstPage, groupsMax, type Page } from "../src/state/page";

const full: Page = {
  run: "3f2a9c01e071571a983d824a22ac7994",
  archive: "a & b=c#d.h5",
  view: "list",
  chips: [
    { id: 1, text: "die 1 in x 0..20mm y -5..5mm during 0.4..0.6s", isNot: false, isOn: true },
    { id: 2, text: '"odd + name%&=#" touches any', isNot: true, isOn: true },
    { id: 3, text: "events < 40", isNot: false, isOn: false },
    { id: 4, text: "not:x\nor über", isNot: true, isOn: false },
  ],
  notesFilter: { star: true, tag: "rot & grün", hidden: "only" },
  grouping: { groups: 7, by: "hierarchy" },
  path: [
    { groups: 12, by: "medoids", representative: "c0.250", query: "" },
    { groups: 5, by: "hierarchy", representative: "find.3", query: "(a: x 0..1) and not (b < 2)" },
  ],
  sort: { by: "number", number: "offsets[2]", isDescending: true },
  selected: ["c0.250", "find.3"],
  playing: ["c1.17", "c0.250"],
  sync: "contact",
  camera: { azimuth: -1.25, elevation: 0.5, zoom: 2, target: [0.01, -0.02, 0] },
  timeS: 0.4167,
  plot: "trace.log_prior",
};

test("a full page survives a round trip", () => {
  assert.deepEqual(pageOf(linkOf(full)), full);
  assert.deepEqual(pageOf(`#${linkOf(full)}`), full);
});

test("the first page has an empty link", () => {
  assert.equal(linkOf(firstPage), "");
  assert.deepEqual(pageOf(""), firstPage);
});

test("a sort by likeness and a camera without a target survive a round trip", () => {
  const page: Page = {
    ...firstPage,
    camera: { azimuth: 0.5, elevation: 0.25, zoom: 1, target: null },
    sort: { by: "alike", to: ["c0.1", "find.2"], isUnlike: true },
  };
  assert.deepEqual(pageOf(linkOf(page)), page);
});

test("invalid parts are skipped", () => {
  const page = pageOf(
    "view=nonsense&q=in:&q=bad&q=in:a<1&groups=medoids-9999&sort=%&camera=1,2&t=soon" +
      "&selected=<b>,0.1&hidden=x&in=zzz",
  );
  assert.equal(page.view, "groups");
  assert.deepEqual(
    page.chips.map(({ text }) => text),
    ["a<1"],
  );
  assert.equal(page.grouping.groups, groupsMax);
  assert.deepEqual(page.sort, { by: "kept" });
  assert.equal(page.camera, null);
  assert.equal(page.timeS, null);
  assert.deepEqual(page.selected, ["c0.1"]);
  assert.deepEqual(page.path, []);
  assert.deepEqual(pageOf("q=".repeat(300_000)), firstPage);
});

test("changes of time, camera and selection add no entries to the browser's history", () => {
  const later: Page = { ...full, timeS: 1, camera: null, selected: [] };
  assert.equal(placeOf(full), placeOf(later));
  assert.notEqual(placeOf(full), placeOf({ ...full, view: "groups" }));
});
