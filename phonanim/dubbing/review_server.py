"""The server of a review: on this machine alone, and for those who have its token."""

from __future__ import annotations

import hmac
import html
import json
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Lock
from urllib.parse import parse_qs, urlsplit

from phonanim.core.decode import parse_json
from phonanim.core.text import printable
from phonanim.dubbing.review import Review, list_page
from phonanim.dubbing.review_line import ACTIONS, Desk, act, line_page
from phonanim.dubbing.review_table import review_csv
from phonanim.errors import ConflictError, PhonanimError

HOST = "127.0.0.1"
LARGEST = 16 * 2**20  # bytes of a request
LITTLE = 2**16  # bytes that are read of a request that is refused
HEADERS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "SAMEORIGIN",
}
TOKEN = "X-Phonanim-Token"


@dataclass(frozen=True, slots=True)
class Answer:
    """What is sent: a page by default."""

    status: HTTPStatus
    text: str
    kind: str = "text/html; charset=utf-8"


class ReviewServer(ThreadingHTTPServer):
    """Serves the list at /, the line number n of it at /line?n=, and what their pages ask.

    Pages need ?token=, what is posted the header X-Phonanim-Token.
    """

    daemon_threads = True

    def __init__(self, review: Review, token: str, port: int = 0, who: str = "") -> None:
        super().__init__((HOST, port), _Handler)
        self.token, self.who = token, who
        self.desk = Desk(review, review.decisions())
        self.lock = Lock()  # lines are made one at a time

    def handle_error(self, request: object, client_address: object) -> None:
        """Tell of faults, but not of a client that leaves before its answer."""
        if not isinstance(sys.exc_info()[1], OSError):
            super().handle_error(request, client_address)  # type: ignore[arg-type]

    @property
    def address(self) -> str:
        """The address of the list, with the token."""
        return f"http://{HOST}:{self.server_port}/?token={self.token}"

    def answer(self, target: str, headers: Mapping[str, str]) -> Answer:
        """The page for a request."""
        try:
            url = urlsplit(target)
            query = {name: values[0] for name, values in parse_qs(url.query).items()}
        except ValueError:
            return Answer(HTTPStatus.BAD_REQUEST, "this is not an address")
        if why := self.refusal(headers, query.get("token", "")):
            return Answer(HTTPStatus.FORBIDDEN, why)
        try:
            return self._found(url.path, query)
        except (PhonanimError, OSError) as error:
            return Answer(HTTPStatus.OK, _message(str(error)))

    def _found(self, path: str, query: Mapping[str, str]) -> Answer:
        review, lines = self.desk.review, len(self.desk.review.outcomes)
        if path == "/":
            return Answer(HTTPStatus.OK, list_page(review, self.desk.decisions, self.token, self.who))
        if path == "/list.csv":
            return Answer(HTTPStatus.OK, review_csv(self.desk), "text/csv; charset=utf-8")
        if path == "/news":
            last, states = self.desk.decisions.news(_number(query.get("after", "")) or 0)
            found = {"last": last, "states": {id: asdict(state) for id, state in states.items()}}
            return _json(HTTPStatus.OK, found)
        number = _number(query.get("n", ""))
        if path != "/line" or number is None:
            return Answer(HTTPStatus.NOT_FOUND, "there is no such page")
        if number >= lines:
            return Answer(HTTPStatus.NOT_FOUND, "there is no such line")
        with self.lock:
            page = line_page(self.desk, number, "compare" in query, self.token, self.who)
        return Answer(HTTPStatus.OK, page)

    def post(self, target: str, headers: Mapping[str, str], body: bytes) -> Answer:
        """The answer to something that a page does, which is not refused."""
        if target not in ACTIONS:
            return _json(HTTPStatus.NOT_FOUND, {"error": "there is no such page"})
        try:
            with self.lock:
                return _json(HTTPStatus.OK, act(self.desk, target, parse_json(body)))
        except ConflictError as error:
            return _json(HTTPStatus.CONFLICT, {"error": str(error)})
        except (PhonanimError, ValueError, OSError) as error:
            return _json(HTTPStatus.BAD_REQUEST, {"error": str(error)})

    def refusal(self, headers: Mapping[str, str], token: str) -> str:
        """Why a request is refused, empty if it is not: another host name or origin, or no token."""
        own = {f"{name}:{self.server_port}" for name in (HOST, "localhost")}
        origin = headers.get("Origin")
        if headers.get("Host", "") not in own:
            return "this host is not served here"
        if origin is not None and origin not in {f"http://{name}" for name in own}:
            return "pages of other origins may not read this"
        if not hmac.compare_digest(token.encode(), self.token.encode()):
            return "the token is missing; open the address that phonanim review prints"
        return ""


class _Handler(BaseHTTPRequestHandler):
    server: ReviewServer
    timeout = 30  # seconds without a byte

    def do_GET(self) -> None:
        """Send a page."""
        self._send(self.server.answer(self.path, self._headers()))

    def do_POST(self) -> None:
        """Do what a page asks."""
        length, headers = _number(self.headers.get("Content-Length", "")), self._headers()
        if length is None or length > LARGEST:
            self.close_connection = True
            self._send(_json(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, {"error": "the request is too large"}))
            return
        if why := self.server.refusal(headers, headers.get(TOKEN, "")):  # before the rest is read
            self.rfile.read(min(length, LITTLE))  # else a client that still sends does not read the answer
            self._send(_json(HTTPStatus.FORBIDDEN, {"error": why}))
            return
        self._send(self.server.post(self.path, headers, self.rfile.read(length)))

    def _headers(self) -> dict[str, str]:
        return {name.title(): value for name, value in self.headers.items()}

    def _send(self, answer: Answer) -> None:
        data = printable(answer.text).encode()
        self.send_response(answer.status)
        for name, value in {**HEADERS, "Content-Type": answer.kind}.items():
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)

    def log_message(self, format: str, *args: object) -> None:
        """Keep quiet."""


def _number(text: str) -> int | None:
    """A whole number, None for anything else."""
    return int(text) if text.isascii() and text.isdigit() and len(text) < 16 else None


def _json(status: HTTPStatus, value: object) -> Answer:
    text = json.dumps(value, ensure_ascii=False, separators=(",", ":"))
    return Answer(status, text, "application/json; charset=utf-8")


def _message(text: str) -> str:
    return (
        '<!doctype html><meta charset="utf-8"><meta name="color-scheme" content="dark">'
        f"<title>phonanim</title><p>{html.escape(text)}</p>"
    )
