// Random numbers from a printed seed: SLEIGHT_SEED, or a new one each time.
export class Random {
  constructor(seed = Number(process.env.SLEIGHT_SEED ?? Math.floor(Math.random() * 2 ** 31))) {
    this.seed = seed;
    this.state = seed >>> 0;
    console.log(`seed ${seed}`);
  }
  /** In [0, 1). Mulberry32. */
  uniform() {
    this.state = (this.state + 0x6d2b79f5) >>> 0;
    let t = this.state;
    t = Math.imul(t ^ (t >>> 15), t | 1);
    t ^= t + Math.imul(t ^ (t >>> 7), t | 61);
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  }
  between(low, high) { return low + (high - low) * this.uniform(); }
  below(bound) { return Math.floor(bound * this.uniform()); }
  of(list) { return list[this.below(list.length)]; }
  /** `count` different elements of the list. */
  some(list, count) {
    const rest = [...list];
    return Array.from({ length: Math.min(count, rest.length) }, () => rest.splice(this.below(rest.length), 1)[0]);
  }
}
