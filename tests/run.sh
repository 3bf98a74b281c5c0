#!/usr/bin/env bash
# Gets what the tests need, then runs every one of them. Usage: tests/run.sh [--fast]
#   --fast   leaves out formatting, lints and documentation
# Needs git, a Rust toolchain by rustup and, for what is missing, Debian's package manager (as root) - or it prints
# the line to run. Ends with one line per part; exit 0 only when all of them passed.
set -euo pipefail
cd "$(dirname "$0")/.."

fast=no
case "${1:-}" in
  "") ;;
  --fast) fast=yes ;;
  *) sed -n '2,5p' "$0"; exit 2 ;;
esac

targets=(thumbv7m-none-eabi thumbv7em-none-eabihf thumbv8m.main-none-eabihf)
started=$SECONDS
passed=()

part() { # name, command...
  local name=$1 from=$SECONDS
  shift
  printf '\n== %s\n' "$name"
  if ! "$@"; then
    printf '\nFAILED: %s\n  to repeat: %s\n' "$name" "$*" >&2
    exit 1
  fi
  passed+=("$(printf '%5d s  %s' $((SECONDS - from)) "$name")")
}

need_targets() {
  local missing=() target
  for target in "${targets[@]}"; do
    [ -d "$(rustc --print sysroot)/lib/rustlib/$target" ] || missing+=("$target")
  done
  [ ${#missing[@]} -eq 0 ] && return
  if command -v rustup >/dev/null; then
    rustup target add "${missing[@]}"
  else
    echo "The Rust targets ${missing[*]} are missing. Install rustup (https://rustup.rs) and run: rustup target add ${missing[*]}" >&2
    return 1
  fi
}

need_packages() {
  local packages=()
  command -v cc >/dev/null || packages+=(gcc libc6-dev)
  command -v qemu-system-arm >/dev/null || packages+=(qemu-system-arm)
  command -v arm-none-eabi-gcc >/dev/null || packages+=(gcc-arm-none-eabi libnewlib-arm-none-eabi)
  [ ${#packages[@]} -eq 0 ] && return
  if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${packages[@]}"
  else
    echo "Programs are missing. Run: sudo apt-get install --no-install-recommends ${packages[*]}" >&2
    return 1
  fi
}

core_for_every_target() {
  local target
  for target in "${targets[@]}"; do
    cargo build -q -p varsac-core --release --target "$target"
  done
}

part "Rust targets" need_targets
part "emulator and compilers" need_packages
if [ $fast = no ]; then
  part "formatting" cargo fmt --all --check
  part "lints" cargo clippy -q --workspace --all-targets -- -D warnings
  part "documentation" env RUSTDOCFLAGS="-D warnings" cargo doc -q --workspace --no-deps
fi
part "core alone, debug" cargo test -q -p varsac-core
part "core alone, release" cargo test -q -p varsac-core --release
part "core with serde and defmt" cargo test -q -p varsac-core --release --features serde,defmt
part "core compiled for this processor" env RUSTFLAGS="-C target-cpu=native" CARGO_TARGET_DIR=target/native cargo test -q -p varsac-core --release
part "core for every target" core_for_every_target
part "everything together" cargo test -q --workspace --release

printf '\nAll passed in %d s:\n' $((SECONDS - started))
printf '%s\n' "${passed[@]}"
