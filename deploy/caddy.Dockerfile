# Caddy that needs no root: folders of its user, and a binary without the capability to bind port 443.
FROM caddy:2.10.2-alpine
RUN install -d -o 10001 -g 10001 /data /config \
  && cp /usr/bin/caddy /usr/bin/caddy.plain && mv /usr/bin/caddy.plain /usr/bin/caddy
USER 10001:10001
ENV XDG_CONFIG_HOME=/tmp
