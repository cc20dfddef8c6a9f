#!/bin/sh
# Goal: Sleight's arithmetic gives the same bits on processors with and without fused multiply-add
# (FMA) and AVX2, and when compiled for AVX2. The arithmetic of libm gives different bits, which
# shows that the comparison can fail. Method: compare the hashes that arithmetic_probe prints in
# four runs. The first run is plain. The second run uses glibc's switch that hides AVX2 and FMA, so
# that libm takes its other variants. The third run has a program compiled for AVX2. The fourth run
# is a negative control: its program is compiled for AVX2 with permission to regroup sums and to
# multiply by reciprocals.
#   same_bits.sh PROBE PROBE_AVX2 PROBE_LICENSED     exit 0 pass, 1 fail, 77 not decidable here
set -eu
probe=$1
probe_avx2=$2
probe_licensed=$3
failures=0

# hash_of NAME OUTPUT: prints the hash on NAME's line.
hash_of() { printf '%s\n' "$2" | sed -n "s/^$1 //p"; }
fail() { echo "FAIL: $*" >&2; failures=1; }
expect_same() { if [ -z "$2" ] || [ "$2" != "$3" ]; then fail "$1: '$2' against '$3'"; fi; }
expect_other() { if [ -z "$2" ] || [ "$2" = "$3" ]; then fail "$1: '$2' both times"; fi; }

plain=$("$probe")
hidden=$(GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA "$probe")
printf 'as is:\n%s\nAVX2 and FMA hidden from glibc:\n%s\n' "$plain" "$hidden"
expect_same "sleight, AVX2 and FMA hidden" \
  "$(hash_of sleight "$plain")" "$(hash_of sleight "$hidden")"

if grep -qw avx2 /proc/cpuinfo && grep -qw fma /proc/cpuinfo; then
  expect_other "libm (negative control; is GLIBC_TUNABLES honoured?)" \
    "$(hash_of libm "$plain")" "$(hash_of libm "$hidden")"
  avx2=$("$probe_avx2")
  licensed=$("$probe_licensed")
  printf 'compiled for AVX2:\n%s\nand with licence:\n%s\n' "$avx2" "$licensed"
  expect_same "sleight, compiled for AVX2" \
    "$(hash_of sleight "$plain")" "$(hash_of sleight "$avx2")"
  expect_other "sleight, with licence (negative control)" \
    "$(hash_of sleight "$plain")" "$(hash_of sleight "$licensed")"
elif [ "$failures" -eq 0 ]; then
  echo "SKIP: this processor has no AVX2 or no FMA, so there is no other variant to compare"
  exit 77
fi
if [ "$failures" -eq 0 ]; then echo "PASS"; fi
exit "$failures"
