"""Delivery of webhook events: signed, to public addresses, with retries."""

from __future__ import annotations

import base64
import hashlib
import hmac
import logging
import threading
import time
from collections.abc import Sequence

from pointbrush.errors import PointbrushError, UnavailableError
from pointbrush.exchange.outgoing import Bounds, exchange, parse_url, resolve
from pointbrush.teamwork.webhooks import TOPICS, Delivery, Webhook, Webhooks
from pointbrush.values.team.webhooks import Topic

log = logging.getLogger(__name__)
LOOK_SECONDS = 1.0
"""Polling interval of the outbox."""
FOLD_SECONDS = 60.0
"""Interval at which edits of labels are combined into an event."""
ANSWER_SECONDS = 10.0
"""Timeout of a whole request to a receiver."""
LONGEST_ERROR = 200
END_SECONDS = 2.0
"""Longest wait for receivers when the server ends."""
AT_ONCE = 32
"""Limit of concurrent receivers, each with its own thread."""


class Hooks:
    """The webhooks of a workspace, and the threads that deliver events; thread-safe."""

    def __init__(self, webhooks: Webhooks, *, private: bool) -> None:
        """``private``: also allow addresses of this machine and its networks."""
        self._webhooks, self._private = webhooks, private
        self.all, self.remove, self.deliveries = webhooks.all, webhooks.remove, webhooks.deliveries
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="pointbrush-webhooks", daemon=True)
        self._lock = threading.Lock()
        self._telling: dict[str, threading.Thread] = {}  # by webhook
        self._delivered: dict[str, float] = {}  # time of the last delivery

    def add(self, project: str, url: str, topics: Sequence[Topic] | None = None) -> Webhook:
        """Add a webhook of a project, by default for all topics.

        Raises BadInputError for an invalid address, ForbiddenError for a private one.
        """
        parsed = parse_url(url)
        resolve(parsed.host, parsed.port or 443, public=not self._private)
        return self._webhooks.add(project, url, topics or list(TOPICS))

    def open(self) -> None:
        """Start the delivery of events."""
        self._thread.start()

    def close(self) -> None:
        """Stop the delivery; other servers deliver the remaining events."""
        self._stop.set()
        with self._lock:
            threads = [self._thread, *self._telling.values()]
        until = time.monotonic() + END_SECONDS
        for thread in threads:
            if thread.ident is not None:
                thread.join(max(0.0, until - time.monotonic()))

    def _run(self) -> None:
        gathered = -FOLD_SECONDS
        while not self._stop.wait(LOOK_SECONDS):
            try:
                if time.monotonic() - gathered >= FOLD_SECONDS:
                    gathered = time.monotonic()
                    self._webhooks.gather()
                self.tell()
            except UnavailableError as error:
                log.warning("webhooks wait: %s", error)
            except Exception:
                if self._stop.is_set():  # the workspace was closed
                    return
                log.exception("webhooks could not be delivered")

    def tell(self) -> None:
        """Start to deliver due events, with one thread per receiver.

        Above ``AT_ONCE``, receivers with the oldest last delivery come first.
        """
        waiting = self._webhooks.waiting()
        with self._lock:
            self._delivered = {
                each: self._delivered.get(each, 0.0) for each in {*waiting, *self._telling}
            }
            for webhook in sorted(waiting, key=self._delivered.__getitem__):
                if webhook in self._telling or len(self._telling) >= AT_ONCE:
                    continue
                name = f"pointbrush-webhook-{webhook}"
                thread = threading.Thread(
                    target=self._tell_one, args=(webhook,), name=name, daemon=True
                )
                self._telling[webhook] = thread
                thread.start()

    def _tell_one(self, webhook: str) -> None:
        """Deliver a receiver's due events, a few at a time, until one fails."""
        try:
            error = ""
            while not (error or self._stop.is_set()) and (due := self._webhooks.take(2, webhook)):
                for delivery in due:
                    error = self._send(delivery)
                    self._webhooks.note_delivery(delivery, error)
        except Exception:
            if not self._stop.is_set():
                log.exception("a webhook could not be delivered")
        finally:
            with self._lock:
                self._delivered[webhook] = time.monotonic()
                del self._telling[webhook]

    def _send(self, delivery: Delivery) -> str:
        """Send an event; return the error, or ""."""
        try:
            answer = exchange(
                "POST",
                delivery.url,
                Bounds(ANSWER_SECONDS, answer_bytes=0, public=not self._private),
                headers=headers_of(delivery, int(time.time())),
                body=delivery.body.encode(),
            )
        except PointbrushError as error:
            return str(error)[:LONGEST_ERROR]
        return "" if answer.success else f"answered {answer.status}"


def headers_of(delivery: Delivery, now: int) -> dict[str, str]:
    """Return the headers of an event by Standard Webhooks; ``now``: seconds since the epoch.

    The signature covers id, time and body, which prevents replays by others.
    """
    signed = f"{delivery.id}.{now}.{delivery.body}".encode()
    digest = hmac.new(delivery.secret.encode(), signed, hashlib.sha256).digest()
    return {
        "Content-Type": "application/json",
        "webhook-id": delivery.id,
        "webhook-timestamp": str(now),
        "webhook-signature": f"v1,{base64.b64encode(digest).decode()}",
    }
