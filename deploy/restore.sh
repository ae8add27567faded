#!/bin/sh
# Put a backup in the place of what the servers show; what they showed is kept under another name.
#   deploy/restore.sh 2026-05-04T03-02-01
set -eu
backup=${1:?name a backup: docker compose run --rm backup ls /backups}
kept=before_$(date -u +%Y_%m_%dT%H_%M_%S)
cd "$(dirname "$0")/.."
docker compose stop pointbrush-1 pointbrush-2 worker
docker compose exec postgres psql --username pointbrush --dbname postgres --set ON_ERROR_STOP=1 \
  --command "ALTER DATABASE pointbrush RENAME TO \"$kept\"" --command "CREATE DATABASE pointbrush"
docker compose run --rm --no-deps backup sh -euc \
  'test -d "/backups/$0"; mv /workspace/lab "/workspace/$1"; exec pointbrush restore "/backups/$0"' \
  "$backup" "$kept"
docker compose up --detach --wait
