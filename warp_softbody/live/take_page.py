"""A finished take and its player as one page that asks for nothing."""

from __future__ import annotations

import base64
import hashlib
import html
import zlib

from warp_softbody.live.outline import SceneOutline
from warp_softbody.live.page_files import PAGE, player_script, three_licence
from warp_softbody.live.wire import LENGTH, Moment, UpdateEncoder, as_text


class TakePage:
    """The bytes of such a page, piece by piece: `begin`, `add` for each moment, `end`.

    Its policy lets nothing run but the player, and nothing be asked for from anywhere.
    """

    def __init__(self, outline: SceneOutline) -> None:
        """Of a take with an outline."""
        self._outline = outline
        self._encoder = UpdateEncoder(outline.points, differences=True)
        self._packer = zlib.compressobj(9)
        self._rest = b""

    def begin(self) -> bytes:
        """All before the take, and the outline."""
        style = (PAGE / "page.css").read_text(encoding="utf-8")
        script = (PAGE / "take_start.js").read_text(encoding="utf-8")
        player = player_script()
        policy = (
            f"default-src 'none'; script-src {_hash(script)} {_hash(player)}; "
            f"style-src {_hash(style)}; base-uri 'none'; form-action 'none'"
        )
        packed = base64.b64encode(zlib.compress(player.encode(), 9)).decode()
        head = (
            "<!doctype html>\n"
            f"<!--\nThe player holds three.js.\n\n{three_licence()}-->\n"
            '<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
            '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            f"<title>{html.escape(self._outline.name)}</title>\n"
            f"<style>{style}</style>\n</head>\n<body>\n"
            f'<script type="text/plain" id="player">{packed}</script>\n'
            '<script type="text/plain" id="take">'
        )
        outline = as_text(self._outline.as_json())
        return head.encode() + self._packed(LENGTH.pack(len(outline)) + outline)

    def add(self, moment: Moment) -> bytes:
        """A moment; often nothing, as bytes wait to be packed together."""
        update = self._encoder.encode(moment)
        return self._packed(LENGTH.pack(len(update)) + update)

    def end(self) -> bytes:
        """What is left, and the start of the player."""
        script = (PAGE / "take_start.js").read_text(encoding="utf-8")
        left = base64.b64encode(self._rest + self._packer.flush())
        return left + f"</script>\n<script>{script}</script>\n</body>\n</html>\n".encode()

    def _packed(self, contents: bytes) -> bytes:
        """Base64 of what the packer gives out, three bytes by three."""
        ready = self._rest + self._packer.compress(contents)
        whole = len(ready) - len(ready) % 3
        self._rest = ready[whole:]
        return base64.b64encode(ready[:whole])


def _hash(text: str) -> str:
    """As a content security policy names what may run."""
    digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
    return f"'sha256-{digest}'"
