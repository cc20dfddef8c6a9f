/** Returns `fast` in `deploy/test`, and `all` in `deploy/test --all`, which sets SLEIGHT_ALL. */
export function ofTier(fast: number, all: number): number {
  return process.env["SLEIGHT_ALL"] === "1" ? all : fast;
}
