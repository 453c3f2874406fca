"""What `isoembed.embed` returns: a surface with the metric that it realizes, and how it was found."""
