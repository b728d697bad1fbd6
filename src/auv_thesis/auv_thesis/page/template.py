"""The frame of the page: head, styles and the order of its sections."""

from __future__ import annotations

from string import Template

PAGE = Template("""\
$head
<body>
<header>
<h1>$title</h1>
<p class="facts">$facts</p>
</header>
<main>
$failures
<section>
<h2>In short</h2>
<p>Each claim, table and figure of the simulations in the thesis behind this project (Sahu 2015), made again
from our own runs. Each verdict is computed from the numbers beside it. Unfavourable results are shown, too.
Items that the thesis does not have are numbered with a letter.</p>
$counts
</section>
<nav aria-label="Contents">
<h2>Contents</h2>
<ul class="contents">
$contents
<li><a href="#how">How it was made</a></li>
</ul>
</nav>
<section>
<h2>The thesis's claims</h2>
$claims
</section>
$chapters
<section id="how">
<h2>How it was made</h2>
<pre>$command</pre>
<p>Every run behind this page is flown in one process from a scenario of this project, with the changes in
its line. A second call flies only runs that changed.</p>
<div class="scroll">
$versions
</div>
<details><summary>All runs, with their durations</summary>
<div class="scroll">
$runs
</div>
</details>
</section>
</main>
</body>
</html>
""")
