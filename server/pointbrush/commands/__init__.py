"""The commands: one module per subject, one function per verb beside its arguments.

A verb calls the client's interface: ``pointbrush.client`` for the workspace of a server, ``local``
for one of this machine.  Modules of verbs import the server's parts on first use.
"""
