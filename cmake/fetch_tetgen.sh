#!/bin/bash
# Fetches the source of TetGen 1.5.0 (AGPL-3+) as Debian ships it: fetch_tetgen.sh DIR
#
# Works without root and leaves the system's configuration alone: package lists, cache and the source list live in a
# temporary folder; the archive's address is the one from which this machine gets its own packages.
set -euo pipefail

version=1.5.0
target=$(realpath -m "${1:?usage: fetch_tetgen.sh DIR}")
if [ -f "$target/tetgen.cxx" ]; then exit 0; fi

fail() { echo "fetch_tetgen: $*" >&2; exit 1; }
command -v apt-get >/dev/null || fail "needs apt-get; put tetgen.cxx, tetgen.h and predicates.cxx of TetGen $version into $target by hand"

release=$(. /etc/os-release && echo "${VERSION_CODENAME:-}")
[ -n "$release" ] || fail "/etc/os-release names no release"

mkdir -p "$(dirname "$target")"
work=$(mktemp -d "$(dirname "$target")/tetgen-fetch.XXXXXX")
trap 'rm -rf "$work"' EXIT
mkdir -p "$work"/{lists/partial,cache/archives/partial,source}

# Every main component of this release that the system knows, as source entries.
keyring=/usr/share/keyrings/debian-archive-keyring.gpg
options=''
if [ -f "$keyring" ]; then options="[signed-by=$keyring] "; fi
apt-get indextargets --format '$(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' |
  awk -v release="$release" -v options="$options" \
    '$2 == release && $3 == "main" { print "deb-src " options $1 " " $2 " " $3 }' | sort -u > "$work/sources.list"
[ -s "$work/sources.list" ] || fail "this machine has no package source for $release main"

private=(
  -o "Dir::Etc::SourceList=$work/sources.list" -o Dir::Etc::SourceParts=/dev/null
  -o "Dir::State::Lists=$work/lists" -o "Dir::Cache=$work/cache"
  -o "APT::Sandbox::User=$(id -un)" -o Acquire::Languages=none -o Acquire::Retries=3 -q
)
apt-get "${private[@]}" update > "$work/log" 2>&1 || { cat "$work/log" >&2; fail "apt-get update failed"; }
(cd "$work/source" && apt-get "${private[@]}" source --download-only tetgen) >> "$work/log" 2>&1 ||
  { cat "$work/log" >&2; fail "apt-get source tetgen failed"; }

archive=$(ls "$work/source"/tetgen_"$version".orig.tar.* 2>/dev/null | head -n 1) || true
[ -n "$archive" ] || fail "the package archive has another version than $version: $(ls "$work/source")"
mkdir "$work/tree"
tar -xf "$archive" -C "$work/tree" --strip-components=1
for file in tetgen.cxx tetgen.h predicates.cxx LICENSE; do
  [ -f "$work/tree/$file" ] || fail "$file is missing in $archive"
done
rm -rf "$target"
mv "$work/tree" "$target"
