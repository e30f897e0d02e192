#!/bin/sh
# Makes three.min.js and its licence anew, from npm: ./bundle_three.sh (needs npm and a network; nothing else here does).
set -eu
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp "$here/three_subset.js" "$work"
cd "$work"
npm install --no-save --silent three@0.187.0 esbuild@0.25.10
npx esbuild three_subset.js --bundle --minify --format=iife --global-name=THREE --legal-comments=none \
  --banner:js="/* three.js 0.187.0, MIT licence: three.LICENSE.txt */" --outfile="$here/three.min.js" --log-level=warning
cp node_modules/three/LICENSE "$here/three.LICENSE.txt"
