"""The server of a review: on this machine alone, and for those who have its token."""

from __future__ import annotations

import hmac
import html
from collections.abc import Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Lock
from urllib.parse import parse_qs, urlsplit

from phonanim.dubbing.review import Review, line_page, list_page
from phonanim.errors import PhonanimError

HOST = "127.0.0.1"
HEADERS = {
    "Content-Type": "text/html; charset=utf-8",
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "SAMEORIGIN",
}


class ReviewServer(ThreadingHTTPServer):
    """Serves the list at / and the line number n of it at /line?n=; both need ?token=."""

    daemon_threads = True

    def __init__(self, review: Review, token: str, port: int = 0) -> None:
        super().__init__((HOST, port), _Handler)
        self.review, self.token = review, token
        self.lock = Lock()  # pages are made one at a time

    @property
    def address(self) -> str:
        """The address of the list, with the token."""
        return f"http://{HOST}:{self.server_port}/?token={self.token}"

    def answer(self, target: str, headers: Mapping[str, str]) -> tuple[HTTPStatus, str]:
        """The status and the page for a request."""
        url = urlsplit(target)
        query = parse_qs(url.query)
        if why := self._refusal(headers, query.get("token", [""])[0]):
            return HTTPStatus.FORBIDDEN, why
        if url.path == "/":
            return HTTPStatus.OK, list_page(self.review, self.token)
        number = query.get("n", [""])[0]
        if url.path != "/line" or not (number.isascii() and number.isdigit() and len(number) < 9):
            return HTTPStatus.NOT_FOUND, "there is no such page"
        if int(number) >= len(self.review.outcomes):
            return HTTPStatus.NOT_FOUND, "there is no such line"
        try:
            with self.lock:
                return HTTPStatus.OK, line_page(self.review, int(number))
        except (PhonanimError, OSError) as error:
            return HTTPStatus.OK, _message(str(error))

    def _refusal(self, headers: Mapping[str, str], token: str) -> str:
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

    def do_GET(self) -> None:
        """Answer a request."""
        status, page = self.server.answer(self.path, {n.title(): v for n, v in self.headers.items()})
        data = page.encode()
        self.send_response(status)
        for name, value in HEADERS.items():
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)

    def log_message(self, format: str, *args: object) -> None:
        """Keep quiet."""


def _message(text: str) -> str:
    return (
        '<!doctype html><meta charset="utf-8"><meta name="color-scheme" content="dark">'
        f"<title>phonanim</title><p>{html.escape(text)}</p>"
    )
