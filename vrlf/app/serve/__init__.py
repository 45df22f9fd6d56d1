"""Serving a phone: ``vrlf serve``.

========== ======================================================================
file       holds
========== ======================================================================
gate       how many connections there are, counted before they are read
door       who gets in: token, host, origin; patience with those who do not
certificate the TLS certificate that is made on first use
address    where to listen, and what address a phone is given
where      ``Where``: the listening socket, the address with its token, its QR code
wire       the messages, each checked; encodings, and which a link carries faster
slots      the newest frame in shared memory, between the two processes
page       the page with its script and style, and its headers
answers    headers as lists, and answers to requests
phones     the phones that were let in, and which goes for another
server     the server's process: sockets, phones, nothing of the GPU
head       from a phone's sensors to the head: filter, prediction
drawing    the preview's session and frames without a window
mirrored   the same of a window that is open beside: ``vrlf preview --phone``
loop       ``Broadcast``: the drawing process's loop
========== ======================================================================

The page is in ``assets/phone``.
"""
