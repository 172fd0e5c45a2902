"""The owner of a session: a program that it does not outlive."""

import os
import signal
import threading


def end_with_owner() -> None:
    """End this session when its owner, which holds its standard input open, has gone."""

    def wait() -> None:
        while os.read(0, 1):
            pass
        # to the main thread, which obeys signals: it may be waiting
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGTERM)

    threading.Thread(target=wait, name="owner", daemon=True).start()
