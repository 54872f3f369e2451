from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from rovernav.adapters import DaskExecutor, connect
from tests.adapters.clusters import Cluster, running, wait_for_workers


@pytest.fixture(scope="session")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    """A scheduler and two workers; whoever harms them waits until they are back."""
    with running(tmp_path_factory.mktemp("cluster"), 2) as found:
        yield found


@pytest.fixture(scope="session")
def session_client(cluster: Cluster) -> Iterator[Any]:
    client = connect(cluster.address, timeout=120.0)
    wait_for_workers(client, 2)
    yield client
    client.close()


@pytest.fixture
def client(session_client: Any) -> Iterator[Any]:
    wait_for_workers(session_client, 2)
    yield session_client
    wait_for_workers(session_client, 2)


@pytest.fixture
def executor(client: Any) -> Iterator[DaskExecutor]:
    found = DaskExecutor(client)
    yield found
    found.forget()
