"""The engine that the options of a run name: this machine, or the workers of a Dask cluster."""

from functools import partial

from hairpipe.graph.engine.dask_engine import DaskEngine
from hairpipe.graph.engine.host import Host
from hairpipe.graph.engine.local_engine import MACHINE, LocalEngine
from hairpipe.graph.engine.offer import Offer, sent_offer
from hairpipe.graph.engine.protocol import Engine, Slots
from hairpipe.graph.plan.resolve import Resolver
from hairpipe.graph.run.events import Options


def make_engine(resolver: Resolver, options: Options) -> Engine:
    """Make the engine of a run; BadInput for a scheduler without TLS that is not allowed.

    resolver  of the run: its store, and the code behind its keys, which a host on this machine need not digest again
    options   number of processes and spare ones on this machine, or the address of a scheduler
    """
    codes = {node.type.module: resolver.codes[node.name].digest for node in resolver.graph.nodes.values()}
    modules = tuple(sorted(codes))
    if options.scheduler is not None:
        send = partial(sent_offer, resolver.store, options.codec, resolver.graph.folder, modules)
        return DaskEngine(options.scheduler, send, insecure=options.insecure)
    offer = Offer(str(resolver.store.root), options.codec, str(resolver.graph.folder), modules)
    threads = max(1, options.jobs // options.scans)
    host = Host(offer, MACHINE, threads, resolver.reader, codes, options.spare, outlives=options.outlives)
    return LocalEngine(host, Slots(options.scans, options.jobs))
