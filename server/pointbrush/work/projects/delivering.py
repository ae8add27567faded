"""Events told to webhooks: signed, to public addresses, again and again until they are taken."""

from __future__ import annotations

import base64
import hashlib
import hmac
import logging
import threading
import time

from pointbrush.errors import PointbrushError, UnavailableError
from pointbrush.labels.webhooks import TOPICS, Delivery, Topic, Webhook, Webhooks
from pointbrush.outgoing import Bounds, exchange, parse_url, resolve

log = logging.getLogger(__name__)
LOOK_SECONDS = 1.0
"""Interval in which the outbox is looked at."""
FOLD_SECONDS = 60.0
"""Interval in which edits of labels become an event."""
ANSWER_SECONDS = 10.0
"""For one exchange with a receiver, as a whole."""
LONGEST_ERROR = 200
END_SECONDS = 2.0
"""Longest wait for receivers when the server ends."""
AT_ONCE = 32
"""Receivers that are told at the same time, each by a thread of its own."""


class Hooks:
    """The webhooks of a workspace, and the threads that tell them; thread-safe."""

    def __init__(self, webhooks: Webhooks, *, private: bool) -> None:
        """``private``: addresses of this machine and its networks may be told too."""
        self._webhooks, self._private = webhooks, private
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="pointbrush-webhooks", daemon=True)
        self._lock = threading.Lock()
        self._telling: dict[str, threading.Thread] = {}  # by webhook
        self._told: dict[str, float] = {}  # when each was told last

    def add(self, project: str, url: str, topics: list[Topic] | None = None) -> Webhook:
        """Add a webhook of a project, of all topics unless given.

        Raises BadInputError for no address, ForbiddenError for one that is not public.
        """
        parsed = parse_url(url)
        resolve(parsed.host, parsed.port or 443, public=not self._private)
        return self._webhooks.add(project, url, topics or list(TOPICS))

    def all(self, project: str) -> list[Webhook]:
        """Return the webhooks of a project."""
        return self._webhooks.all(project)

    def remove(self, project: str, webhook: str) -> None:
        """Remove one; raises NotFoundError."""
        self._webhooks.remove(project, webhook)

    def deliveries(self, project: str, webhook: str) -> list[Delivery]:
        """Return the latest events of a webhook, the newest first."""
        return self._webhooks.deliveries(project, webhook)

    def open(self) -> None:
        """Tell events from now on."""
        self._thread.start()

    def close(self) -> None:
        """Stop; what is not told is told by the next server."""
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
                if self._stop.is_set():  # the workspace was closed meanwhile
                    return
                log.exception("webhooks could not be told")

    def tell(self) -> None:
        """Begin to tell events that are due, each receiver by itself: a slow one delays no other.

        Where there are more than ``AT_ONCE`` those come first that were told the longest ago.
        """
        waiting = self._webhooks.waiting()
        with self._lock:
            self._told = {each: self._told.get(each, 0.0) for each in {*waiting, *self._telling}}
            for webhook in sorted(waiting, key=self._told.__getitem__):
                if webhook in self._telling or len(self._telling) >= AT_ONCE:
                    continue
                name = f"pointbrush-webhook-{webhook}"
                thread = threading.Thread(
                    target=self._tell_one, args=(webhook,), name=name, daemon=True
                )
                self._telling[webhook] = thread
                thread.start()

    def _tell_one(self, webhook: str) -> None:
        """Tell a receiver what is due, a few events at a time, until one does not arrive."""
        try:
            error = ""
            while not (error or self._stop.is_set()) and (due := self._webhooks.take(2, webhook)):
                for delivery in due:
                    error = self._send(delivery)
                    self._webhooks.told(delivery, error)
        except Exception:
            if not self._stop.is_set():
                log.exception("a webhook could not be told")
        finally:
            with self._lock:
                self._told[webhook] = time.monotonic()
                del self._telling[webhook]

    def _send(self, delivery: Delivery) -> str:
        """Send an event; returns the error, or ""."""
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
    """Return the headers of an event, named as Standard Webhooks does; ``now``: epoch seconds.

    The signature is of id, time and body, so that an old event cannot be sent again by others.
    """
    signed = f"{delivery.id}.{now}.{delivery.body}".encode()
    digest = hmac.new(delivery.secret.encode(), signed, hashlib.sha256).digest()
    return {
        "Content-Type": "application/json",
        "webhook-id": delivery.id,
        "webhook-timestamp": str(now),
        "webhook-signature": f"v1,{base64.b64encode(digest).decode()}",
    }
