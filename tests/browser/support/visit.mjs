// A gallery and a visitor for a whole file of tests:
//
//   before(async () => ({ gallery, visitor, page } = await visit([hi, dice])));
//   after(leave);
import { Visitor } from "./browser.mjs";
import { Gallery } from "./gallery.mjs";

const visits = [];

export async function visit(archives) {
  const gallery = await Gallery.start(archives);
  visits.push(gallery.stop.bind(gallery));
  const visitor = await Visitor.enter(gallery);
  visits.push(visitor.close.bind(visitor));
  return { gallery, visitor, page: visitor.page };
}

/** Ends all visits, the last one first. */
export async function leave() {
  while (visits.length > 0) await visits.pop()();
}
