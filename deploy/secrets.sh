#!/bin/sh
# Make the secrets that are not there yet.  The folder is its owner's alone; containers see single
# files of it, as users of their own, and so the files themselves can be read.
set -eu
cd "$(dirname "$0")"
umask 022
mkdir -p secrets certificates ../recordings
chmod 700 secrets
for name in database_password admin_token; do
  if [ ! -s "secrets/$name" ]; then
    head -c 32 /dev/urandom | base64 | tr -d '+/=\n' > "secrets/$name"
  fi
  chmod 444 "secrets/$name"
done
